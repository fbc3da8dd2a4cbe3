"""Results in the formats of other programs: meshes with fields, time series, solids."""
