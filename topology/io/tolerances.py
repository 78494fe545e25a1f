"""Thresholds of reading scenes, each with its unit and reason, by the module that asks them."""

# -- assemble

TABLE_MARGIN = 0.1
"""How far [m] the table is seen beyond the objects on it: none hangs over its edge."""

TABLE_SPACING = 0.005
"""Spacing [m] of a table's points: finer than the distance of two contact points of anything that stands."""

TABLE_REACH = 1.0
"""How far [m] the plane goes on beyond the objects: an arm reaches 0.85."""

FAR_SPACING = 0.03
"""Spacing [m] of the points out there, where nothing stands yet."""

MOST_TABLE_POINTS = 40_000
"""Points a table may have: one of 1 m by 1 m at 5 mm."""

ON_PLANE_SHARE = 0.8
"""Share of a table's points that lie on it; the rest is what the mask's edges add."""

NARROWEST_TABLE = 0.4
"""Narrowest table [m]: plates, trays and books lie as flat, and are narrower."""


# -- bag

APART = 0.1
"""Time [s] between a depth image and its labels: three frames at 30 Hz."""

LONGEST_DEFINITION = 100_000
"""Characters of a message's definition, with all that it uses: those of ROS have up to ten thousand, and this
many take two seconds."""

SAME_PLACE = 1e-3
"""[m] and [rad] within which two frames of one camera are the same place: no pixel of it sees so little."""

SHORTEST = 1e-6
"""Length of a quaternion below which it turns nowhere."""


# -- folder

MOST_LISTED = 5
"""Names listed in a sentence that people read."""


# -- geometry

SAMPLE_SPACING = 0.002
"""Mean distance [m] of a mesh's samples: about what a depth camera sees at 1 m."""

MOST_PIECES = 200
"""Materials or solids of one object at most: scans have a few; readers take the square of it."""


# -- limits

MOST_BYTES = 1 << 28
"""A quarter of a gigabyte, some ten million points: more than any frame of depth cameras. It is held up to
four times over while it is checked, and read within five seconds."""

MOST_OBJECTS = 10_000
"""More labels are one a pixel, or noise: `relate` takes 500 objects unless more are asked for."""


# -- sequence

UNIT = 1e-4
"""Step [m] of stored whole numbers: a tenth of a millimetre, finer than any depth camera."""

FAR_OUT = 0.02
"""Share of the points on each side that may be stray; the table's margin makes up for it."""

TABLE_STEP = 50
"""Every so manieth point says where the table must reach: all frames at once."""


# -- text

LOOKED_AT = 1 << 14
"""Bytes of a text that tell whether it is a cloud: some hundred lines, and headings have a few."""

LINE_BYTES = 150
"""What is held of a line of a text at most while it is read: twice the line, and its point."""

EARLIEST = 1e8
"""[s] since 1970, of a trajectory that begins with a time: no coordinate is as large."""

UNIT_ROW = 1e-3
"""How far a quaternion may be from unit length, a rotation from a rigid one: written with four decimals."""


# -- strict_json and pcd

VALUE_BYTES = 48
"""What is held of a value of JSON or of a word: a number, or half of a list, and its place in one."""


# -- mjcf

AROUND = 1.0
"""[m] by which a plane without an end goes on beyond what stands on it."""

ROUND_SIDES = 48
"""Sides that round primitives get: those of 3 cm are off by 0.07 mm."""
