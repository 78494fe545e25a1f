"""What arms hold with: parallel jaws found in their files, grippers and suction cups to mount on them."""
