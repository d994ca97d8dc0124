"""Prints the minimax coefficients of exp.hpp, log.hpp and atan.hpp: python core/tools/minimax.py.

Remez's exchange: the polynomial whose weighted error has the same size, with alternating signs, at
one point more than it has coefficients. Weights make the error relative to the function's value.
Needs mpmath.
"""

from collections.abc import Callable

from mpmath import mp, mpf

mp.prec = 200
POINTS = 2000  # at which extremes are looked for

Function = Callable[[mpf], mpf]


def remez(f: Function, weight: Function, low: mpf, high: mpf, count: int) -> tuple[list[mpf], mpf]:
    """The `count` coefficients of p, lowest power first, and the greatest |weight (f - p)|."""

    def nodes(intervals: int) -> list[mpf]:
        middle, half = (low + high) / 2, (high - low) / 2
        return [middle - half * mp.cos(mp.pi * k / intervals) for k in range(intervals + 1)]

    # Where a weight is 0, at the ends and in the middle, a condition would say nothing.
    aside = (high - low) / 1000
    reference = [x + aside if abs(x) < 20 * aside else x for x in nodes(count)]
    for _ in range(20):
        system, right = mp.matrix(count + 1, count + 1), mp.matrix(count + 1, 1)
        for i, x in enumerate(reference):
            for j in range(count):
                system[i, j] = weight(x) * x**j
            system[i, count] = (-1) ** i
            right[i] = weight(x) * f(x)
        solution = mp.lu_solve(system, right)
        coefficients, level = list(solution[:count]), abs(solution[count])
        extremes: list[tuple[mpf, mpf]] = []  # of each stretch of one sign
        for x in nodes(POINTS):
            error = weight(x) * (f(x) - mp.polyval(coefficients[::-1], x))
            if not extremes or (extremes[-1][1] > 0) != (error > 0):
                extremes.append((x, error))
            elif abs(error) > abs(extremes[-1][1]):
                extremes[-1] = (x, error)
        while len(extremes) > count + 1:
            extremes.pop(0 if abs(extremes[0][1]) < abs(extremes[-1][1]) else -1)
        reference = [x for x, _ in extremes]
        greatest = max(abs(error) for _, error in extremes)
        if greatest < 1.0005 * level:
            break
    return coefficients, greatest


def show(name: str, f: Function, weight: Function, low: mpf, high: mpf, count: int) -> None:
    """Prints the coefficients rounded to doubles, and their error before that."""
    coefficients, error = remez(f, weight, low, high, count)
    print(f"{name}: greatest error {mp.nstr(error, 3)}")
    for c in coefficients:
        print(f"  {float(c).hex()}")


def main() -> None:
    """All three, over ranges widened for the rounding of reductions."""
    wider, tiny = mpf("1.0001"), mpf(10) ** -12

    half = mp.log(2) / 2 * wider
    show(
        "exp, (e^r - 1 - r) / r^2 in r",
        lambda r: (mp.expm1(r) - r) / r**2 if abs(r) > tiny else mpf(1) / 2 + r / 6,
        lambda r: r**2,
        -half, half, 11,
    )  # fmt: skip
    steepest = (mp.sqrt(2) - 1) / (mp.sqrt(2) + 1) * wider

    def log_rest(u: mpf) -> mpf:
        s = mp.sqrt(u)
        return 2 * (mp.atanh(s) - s) / (s * u) if u > tiny else mpf(2) / 3 + 2 * u / 5

    show(
        "log, (2 artanh(s) - 2 s) / s^3 in s^2",
        log_rest,
        lambda u: u * mp.sqrt(u) / (2 * mp.atanh(mp.sqrt(u))) if u > 0 else mpf(0),
        mpf(0), steepest**2, 8,
    )  # fmt: skip

    def atan_rest(u: mpf) -> mpf:
        t = mp.sqrt(u)
        return (mp.atan(t) - t) / (t * u) if u > tiny else -mpf(1) / 3 + u / 5

    show(
        "atan, (atan(t) - t) / t^3 in t^2",
        atan_rest,
        lambda u: u * mp.sqrt(u) / mp.atan(mp.sqrt(u)) if u > 0 else mpf(0),
        mpf(0), mpf(1), 22,
    )  # fmt: skip


if __name__ == "__main__":
    main()
