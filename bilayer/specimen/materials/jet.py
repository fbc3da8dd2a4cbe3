"""Numbers that carry their first and second derivatives by two variables (forward differentiation).

Arithmetic on jets follows the rules of differentiation and is exact. An energy that is written for
numbers or arrays gives its derivatives when it is called with `Jet.variables`. A derivative that
vanishes identically stays the number 0.0 and costs nothing, however long the arrays are.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Union

from bilayer.specimen.materials.law import Functions

Operand = Union["Jet", Any]


@dataclass(frozen=True, eq=False)
class Jet:
    """A value and its derivatives by x and y.

    Parameters
    ----------
    value : float or array
        The value itself.
    first : (2,) sequence of float or array
        Derivatives by x and by y.
    second : (3,) sequence of float or array
        Second derivatives by xx, xy and yy.
    """

    value: Any
    first: Sequence[Any] = (0.0, 0.0)
    second: Sequence[Any] = (0.0, 0.0, 0.0)
    __array_ufunc__ = None  # arrays leave arithmetic with jets to the jets

    @classmethod
    def variables(cls, x: Any, y: Any) -> tuple["Jet", "Jet"]:
        """Return x and y as the two variables."""
        return cls(x, (1.0, 0.0)), cls(y, (0.0, 1.0))

    def __neg__(self) -> "Jet":
        return self * -1.0

    def __add__(self, other: Operand) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.first, self.second)
        return Jet(
            self.value + other.value,
            [_sum(a, b) for a, b in zip(self.first, other.first, strict=True)],
            [_sum(a, b) for a, b in zip(self.second, other.second, strict=True)],
        )

    __radd__ = __add__

    def __sub__(self, other: Operand) -> "Jet":
        return self + (-other)

    def __rsub__(self, other: Operand) -> "Jet":
        return -self + other

    def __mul__(self, other: Operand) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(
                self.value * other,
                [_product(a, other) for a in self.first],
                [_product(a, other) for a in self.second],
            )
        f, g = self.value, other.value
        (fx, fy), (gx, gy) = self.first, other.first
        fs, gs = self.second, other.second
        cross = (
            _product(2.0, _product(fx, gx)),
            _sum(_product(fx, gy), _product(fy, gx)),
            _product(2.0, _product(fy, gy)),
        )
        return Jet(
            f * g,
            (_sum(_product(fx, g), _product(f, gx)), _sum(_product(fy, g), _product(f, gy))),
            [
                _sum(_sum(_product(a, g), _product(f, b)), c)
                for a, b, c in zip(fs, gs, cross, strict=True)
            ],
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> "Jet":
        return self * (other.reciprocal() if isinstance(other, Jet) else 1 / other)

    def __rtruediv__(self, other: Operand) -> "Jet":
        return self.reciprocal() * other

    def __pow__(self, exponent: float) -> "Jet":
        n, x = exponent, self.value
        return self.composed(x**n, n * x ** (n - 1), n * (n - 1) * x ** (n - 2))

    @property
    def is_linear(self) -> bool:
        """Whether the second derivatives vanish identically."""
        return all(map(_vanishes, self.second))

    def first_along(self, u: Sequence[Any]) -> Any:
        """Return the derivative along a direction, given by its parts along x and y."""
        return _sum(_product(self.first[0], u[0]), _product(self.first[1], u[1]))

    def second_along(self, u: Sequence[Any], v: Sequence[Any]) -> Any:
        """Return the second derivative along two directions, each its parts along x and y."""
        xx, xy, yy = self.second
        total = _product(_product(xx, u[0]), v[0])
        if not _vanishes(xy):
            crossed = _sum(_product(u[0], v[1]), _product(u[1], v[0]))
            total = _sum(total, _product(xy, crossed))
        return _sum(total, _product(_product(yy, u[1]), v[1]))

    def reciprocal(self) -> "Jet":
        """Return 1 over the jet."""
        inverse = 1 / self.value
        square = inverse * inverse
        return self.composed(inverse, -1 * square, 2 * square * inverse)

    def composed(self, value: Any, slope: Any, bend: Any) -> "Jet":
        """Return a function of the jet, given its value and its two derivatives there."""
        fx, fy = self.first
        squares = (_product(fx, fx), _product(fx, fy), _product(fy, fy))
        return Jet(
            value,
            (_product(slope, fx), _product(slope, fy)),
            [
                _sum(_product(bend, a), _product(slope, b))
                for a, b in zip(squares, self.second, strict=True)
            ],
        )

    @staticmethod
    def composed_of(function: "Jet", arguments: tuple["Jet", "Jet"]) -> "Jet":
        """Return a function of two jets, given as a jet of its values and derivatives by them."""
        a, b = arguments
        along_x, along_y = zip(a.first, b.first, strict=True)
        pairs = ((along_x, along_x), (along_x, along_y), (along_y, along_y))
        own = zip(a.second, b.second, strict=True)
        return Jet(
            function.value,
            (function.first_along(along_x), function.first_along(along_y)),
            [
                _sum(function.second_along(u, v), function.first_along(bends))
                for (u, v), bends in zip(pairs, own, strict=True)
            ],
        )


@dataclass(frozen=True)
class JetFunctions:
    """`Functions` of jets.

    Parameters
    ----------
    of_values : Functions
        Those of the jets' values.
    """

    of_values: Functions

    def log(self, x: Jet, /) -> Jet:
        """Return the natural logarithm."""
        inverse = 1 / x.value
        return x.composed(self.of_values.log(x.value), inverse, -1 * inverse * inverse)

    def sqrt(self, x: Jet, /) -> Jet:
        """Return the square root."""
        root = self.of_values.sqrt(x.value)
        return x.composed(root, 0.5 / root, -0.25 / (root * x.value))

    def exp(self, x: Jet, /) -> Jet:
        """Return the exponential."""
        value = self.of_values.exp(x.value)
        return x.composed(value, value, value)


def _vanishes(factor: Any) -> bool:
    """Return whether a derivative is the number 0.0, which it is if it vanishes identically."""
    return isinstance(factor, float) and factor == 0.0


def _product(a: Any, b: Any) -> Any:
    return 0.0 if _vanishes(a) or _vanishes(b) else a * b


def _sum(a: Any, b: Any) -> Any:
    if _vanishes(a):
        return b
    return a if _vanishes(b) else a + b
