"""What clouds fill: the convex parts that hands, loads and placements are checked against."""
