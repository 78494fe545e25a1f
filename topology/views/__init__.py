"""What cameras took: depth images, what they saw to be empty, and what they could not see."""
