// The axes of the machine.

export const AXES = 3;
export const AXIS_NAMES = ["X", "Y", "Z"] as const;
