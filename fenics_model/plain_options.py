"""PETSc options that may come from a file: they choose numbers and methods, and do nothing else.

Other options of PETSc run Python modules, load libraries, and read or write files.
"""

import re

PREFIX = "bilayer_"
"""Of the name of every option for the solver."""

_NUMBER = r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"
_NOTHING = ""
MUMPS_INTEGERS = (4, 6, 7, 8, 10, 11, 12, 13, 14, 23, 24, 27, 28, 29, 35, 36, 37, 38, 58)
"""Those of MUMPS' ICNTL that write no file."""


def _numbers(beginning: str, names: str) -> dict[str, str]:
    return {f"{beginning}_{name}": _NUMBER for name in names.split()}


PLAIN_OPTIONS: dict[str, str] = {
    "snes_type": "newtonls|newtontr",
    "snes_linesearch_type": "basic|bt|l2|cp|nleqerr",
    **_numbers("snes", "rtol atol stol max_it max_funcs divergence_tolerance lag_jacobian "
                       "lag_preconditioner"),
    **_numbers("snes_linesearch", "damping max_it order minlambda rtol atol ltol maxstep"),
    "ksp_type": "preonly|cg|minres|symmlq|gmres|fgmres|bcgs|tfqmr|richardson",
    **_numbers("ksp", "rtol atol divtol max_it gmres_restart"),
    "pc_type": "cholesky|lu|ilu|icc|jacobi|bjacobi|none",
    "pc_factor_mat_solver_type": "mumps|petsc|superlu|superlu_dist|umfpack|cholmod|mkl_pardiso",
    "pc_factor_mat_ordering_type": "natural|nd|rcm|qmd|1wd|amd|metisnd",
    "pc_factor_shift_type": "none|nonzero|positive_definite|inblocks",
    **_numbers("pc_factor", "levels fill zeropivot shift_amount"),
    **_numbers("mat_mumps", " ".join(f"icntl_{number}" for number in MUMPS_INTEGERS)),
    **_numbers("mat_mumps", "cntl_1 cntl_2 cntl_3 cntl_4 cntl_5 cntl_7"),
    **dict.fromkeys(
        ("snes_monitor", "snes_converged_reason", "snes_view", "ksp_monitor",
         "ksp_converged_reason", "ksp_view"), _NOTHING,
    ),
}  # fmt: skip
"""The options by name, without the prefix, each with the pattern of its value.

Those of SNES are in files of earlier versions. They are read; a run that is to use them says that
it does not.
"""


def not_plain_option(text: str) -> str:
    """Return the first of some options that is not plain, with its value; "" if all are.

    Parameters
    ----------
    text : str
        As on a command line.

    Examples
    --------
    >>> not_plain_option("-bilayer_snes_rtol 1e-9 -bilayer_snes_monitor")
    ''
    >>> not_plain_option("-bilayer_pc_type lu -bilayer_ksp_view ascii:a.txt")
    '-bilayer_ksp_view ascii:a.txt'
    """
    words = text.split()
    while words:
        name = words.pop(0)
        values = []
        while words and not _is_name(words[0]):
            values.append(words.pop(0))
        pattern = PLAIN_OPTIONS.get(name.removeprefix(f"-{PREFIX}"))
        is_ours = name.startswith(f"-{PREFIX}") and pattern is not None
        if not is_ours or not re.fullmatch(str(pattern), " ".join(values)):
            return " ".join([name, *values])
    return ""


def _is_name(word: str) -> bool:
    return word.startswith("-") and not re.fullmatch(_NUMBER, word)
