"""In which order to put things down: base first, every partial arrangement standing, fewest holds."""
