"""Numbers for people: rounded, and never minus nothing."""


def rounded(value: float, digits: int = 0) -> str:
    """Write a number with so many digits after the point.

    Args:
        value: The number.
        digits: How many.

    Returns:
        The text; what rounds to zero has no sign, on which side of it the number may lie.
    """
    return f"{round(value, digits) + 0.0:.{digits}f}"
