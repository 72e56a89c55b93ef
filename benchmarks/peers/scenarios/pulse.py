"""A force of 50 ms that is not declared."""


def pulse(t, ne, le, e, ep, nx, lnp, x, xp):
    return t, [], [[2, 1, 20.0 if 3.0031 < t < 3.0531 else 0.0]]
