"""How the forms are compiled: options of the just-in-time compiler."""

JIT_OPTIONS = {
    "cffi_extra_compile_args": ["-O2", "-g0"],
    "timeout": 600,  # s, for the rank that compiles; the default of 10 s is less than it takes
}
