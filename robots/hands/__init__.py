"""What arms hold with: parallel jaws and suction cups."""
