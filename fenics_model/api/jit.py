"""Options of the just-in-time compiler of the forms.

The sums of the kernels may be added up in any order, which lets the compiler compute several terms
at once; infinities and NaNs, which tell of elements turned inside out, stay what they are. Options
for the machine at hand (-march=native) gain little more and would keep the compiled forms from
being used by every machine that shares a home folder.
"""

SUMS_IN_ANY_ORDER = [
    "-fassociative-math",
    "-fno-signed-zeros",
    "-fno-trapping-math",
    "-freciprocal-math",
    "-fno-math-errno",
]

JIT_OPTIONS = {
    "cffi_extra_compile_args": ["-O2", *SUMS_IN_ANY_ORDER, "-g0"],
    "timeout": 600,  # s, for the rank that compiles; the default of 10 s is less than it takes
}
