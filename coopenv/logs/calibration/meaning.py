"""What the keys of a layout's calibration tables mean, for the page on recordings."""

MEANING = {  # table.key -> default, meaning
    "sensors.1.sign": ("1", "-1 where the sensor measures the reaction on itself"),
    "sensors.1.rotation": (
        "none",
        "its axes seen from the object: in the plane an angle, in both a matrix, `{ euler = [...], "
        'order = "ZYX" }` or `{ quaternion = [...], order = "wxyz" }`',
    ),
    "sensors.1.offset": ("0", "from its origin to the grip, along its axes, unit of lengths"),
    "sensors.1.tare": (
        "none",
        "a wrench in its axes, the layout's units, of six numbers in the plane too; or "
        "`{ first = 2.0 }` [s], `{ rests = [[0, 2], "
        '[58, 60]] }` [s], between two of which it drifts linearly, `{ file = "zero.csv" }`, '
        "whose place is told from the layout's folder",
    ),
    "sensors.1.cross_talk": (
        "none",
        "3 by 3 or, in the plane too, 6 by 6: what a reading is multiplied with, in SI units",
    ),
    "sensors.1.load.mass": ("", "of what hangs between sensor and hand [kg]"),
    "sensors.1.load.center": ("0", "of its mass, from the sensor's origin, its axes"),
    "sensors.1.load.inertia": ("none", "about that, the sensor's axes [kg m²]; needs `window`"),
    "sensors.1.load.side": ("hand", "`hand`, as a handle, or `object`, as a gripper"),
    "sensors.1.load.window": ("none", "over which acceleration is found [s]"),
    "pose.orientation": (
        "quaternion",
        "`quaternion`, `matrix`, or, in the unit of angles, `euler` or `rotation_vector`",
    ),
    "pose.columns": ("as documented", "its 4, 9 or 3 columns of the file, a minus turns the sign"),
    "pose.order": (
        "wxyz, rows",
        "`wxyz` or `xyzw`; `rows` or `columns`; axes such as `ZYX` (turning with the object) or "
        "`xyz` (of the world)",
    ),
    "pose.com": ("0", "centre of mass in the tracked frame, unit of lengths"),
    "pose.delay": ("0", "by which pose and twist are late [s]"),
    "filters.wrench": ("none", "cutoff of forces and torques [Hz]"),
    "filters.pose": ("none", "cutoff of the pose [Hz]"),
    "filters.twist": ("none", "cutoff of the twist [Hz]"),
    "filters.order": ("2", "of the filter, which passes twice"),
    "filters.twist_window": ("none", "makes the twist of the pose [s]"),
    "filters.rate": ("as recorded", "of the rows that come out [Hz]"),
    "body.mass": ("none", "of the object [kg]"),
    "body.inertia": ("none", "about its centre of mass: a number; in space 3, or 3 by 3 [kg m²]"),
    "body.drag": ("0, 0", "of translation [N s/m] and of rotation [N m s]"),
    "body.gravity": ("none; −z", "in the world frame [m/s²]; in the plane none, in space along −z"),
}
