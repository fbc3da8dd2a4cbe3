"""The two solvers on sheets of other outlines and patterns: cases, branches, rows, page."""
