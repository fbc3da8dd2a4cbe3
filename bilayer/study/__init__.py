"""Studies: many specimens from one file, computed side by side, resumed, read as one dataset.

study file -> plan -> cases -> folder of results -> index, dataset, figure. A case is one specimen
with one solver; its result is a NetCDF file named by the hash of what defines the case.
"""
