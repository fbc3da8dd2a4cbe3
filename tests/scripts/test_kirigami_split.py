"""The table of how the shapes move with the split of the constants."""

import kirigami_split


def test_the_table_compares_with_the_template(capsys):
    kirigami_split.main(mesh_size=0.012)
    title, _, template, *others = capsys.readouterr().out.splitlines()
    assert title.startswith("| C01/C10 substrate | kirigami | height at 1.06 |")
    assert "%" not in template
    assert len(others) == 3
    assert all(row.count("%") == 6 for row in others)
