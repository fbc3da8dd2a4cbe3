"""The volume mesh of a layered solid, serial and distributed."""
