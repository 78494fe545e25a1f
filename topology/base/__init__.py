"""What every room asks: arrays, checks of arguments and files, errors, plugins, workers."""
