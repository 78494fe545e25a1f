"""What topple answers over the Model Context Protocol: tools that relate, order, judge and plan scenes."""
