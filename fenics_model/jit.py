"""How the forms are compiled: options of the just-in-time compiler.

Options for the machine at hand (-O3 -march=native) were measured to gain nothing on these kernels,
so the compiled forms stay usable by every machine that shares a home folder.
"""

JIT_OPTIONS = {
    "cffi_extra_compile_args": ["-O2", "-g0"],
    "timeout": 600,  # s, for the rank that compiles; the default of 10 s is less than it takes
}
