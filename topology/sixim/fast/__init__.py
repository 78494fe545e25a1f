"""The paper's rule sooner: the same relations and counts, by bounds, tables and early exits."""
