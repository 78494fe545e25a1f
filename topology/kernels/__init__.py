"""Hot loops in C++ with a plain C interface, each beside its twin: a few lines of numpy or scipy."""
