"""A campaign of odd inputs: what is bad is refused in one line, what is good is accepted.

Each module of a class of inputs yields attempts (`attempt`); the campaign runs a choice of them in
forked children of one process that has everything loaded, and judges what each of them did.
"""
