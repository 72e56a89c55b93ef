/* The number type: one double, or LANES doubles, one of each of as many cases of a mechanism that differ in numbers
   only.

   A vector of the compiler does arithmetic on all lanes at once; what it has no operator for is done lane by lane. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if LANES == 1
typedef double real;
#define LANE(a, w) (*((void)(w), &(a)))
#else
typedef double real __attribute__((vector_size(8 * LANES), aligned(8)));
typedef int64_t bits __attribute__((vector_size(8 * LANES), aligned(8)));
#define LANE(a, w) ((a)[w])
#endif
#define EVERY(c) ((c) + (real){0})
#define EACH_LANE for (int w = 0; w < LANES; w++)

#define LANE_BY_LANE(name, f) \
    static inline real name(real a) \
    { \
        double v[LANES]; \
        memcpy(v, &a, sizeof v); \
        EACH_LANE v[w] = f(v[w]); \
        memcpy(&a, v, sizeof v); \
        return a; \
    }
LANE_BY_LANE(lanes_sin, sin)
LANE_BY_LANE(lanes_cos, cos)
LANE_BY_LANE(lanes_sqrt, sqrt)

/* G(c) = 2 acos(c)/sqrt(1 - c^2) and three derivatives (theory-beam-order4.md 2.3): a series in 1 - c near 1. */
static double turn(double c, int order)
{
    const double x = 1.0 - c, q = 1.0 - c * c;
    if (fabs(x) <= 0.2) {
        double g = 2.0, power[4] = {1.0, 0.0, 0.0, 0.0}, sum = 0.0;
        for (int k = 0; k < 22; k++) { /* power: x^k and its derivatives by x */
            sum += g * power[order];
            g *= (k + 1.0) / (2.0 * k + 3.0);
            power[3] = x * power[3] + 3.0 * power[2];
            power[2] = x * power[2] + 2.0 * power[1];
            power[1] = x * power[1] + power[0];
            power[0] *= x;
        }
        return order % 2 ? -sum : sum;
    }
    const double G = c < 1.0 ? 2.0 * acos(c) / sqrt(q) : 2.0 * acosh(c) / sqrt(-q);
    const double G1 = (c * G - 2.0) / q, G2 = (3.0 * c * G1 + G) / q;
    return order == 0 ? G : order == 1 ? G1 : order == 2 ? G2 : (5.0 * c * G2 + 4.0 * G1) / q;
}
#define TURN(k) \
    static inline double turn_##k(double c) { return turn(c, k); } \
    LANE_BY_LANE(lanes_turn##k, turn_##k)
TURN(0)
TURN(1)
TURN(2)
TURN(3)

static inline real lanes_atan2(real a, real b)
{
    real r;
    EACH_LANE LANE(r, w) = atan2(LANE(a, w), LANE(b, w));
    return r;
}

/* Larger of m and |a|, lane by lane; m where a is not a number. */
static inline real lanes_larger(real m, real a)
{
#if LANES == 1
    const double size = fabs(a);
    return size > m ? size : m;
#else
    const real size = (real)((bits)a & INT64_MAX);
    const bits larger = size > m;
    return (real)((larger & (bits)size) | (~larger & (bits)m));
#endif
}

/* Rows of a few right-hand sides: their width is a multiple of ROW numbers, which are one vector of the processor. */
#if LANES == 1
enum { ROW = 4 };
typedef double row_part __attribute__((vector_size(8 * ROW), aligned(8), may_alias));
#else
enum { ROW = 1 };
typedef real row_part;
#endif

/* to += a from. */
static inline void add_row(real *to, real a, const real *from, int width)
{
    for (int c = 0; c < width; c += ROW) *(row_part *)(to + c) += a * *(const row_part *)(from + c);
}

/* The scalar product of two rows. */
static inline real times_row(const real *a, const real *b, int width)
{
    row_part parts = *(const row_part *)a * *(const row_part *)b;
    for (int c = ROW; c < width; c += ROW) parts += *(const row_part *)(a + c) * *(const row_part *)(b + c);
#if LANES == 1
    return (parts[0] + parts[1]) + (parts[2] + parts[3]);
#else
    return parts;
#endif
}

static inline double largest_lane(real a)
{
    double m = LANE(a, 0);
    EACH_LANE if (!(LANE(a, w) <= m)) m = LANE(a, w);
    return m;
}
