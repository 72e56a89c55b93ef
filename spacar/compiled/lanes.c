/* The number type: one double, or LANES doubles, one of each of as many cases of a mechanism that differ in numbers only.

   A vector of the compiler does arithmetic on all lanes at once; what it has no operator for is done lane by lane. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if LANES == 1
typedef double real;
#define LANE(a, w) (*((void)(w), &(a)))
#else
typedef double real __attribute__((vector_size(8 * LANES), aligned(8)));
#define LANE(a, w) ((a)[w])
#endif
#define EVERY(c) ((c) + (real){0})
#define EACH_LANE for (int w = 0; w < LANES; w++)

static inline real lanes_sin(real a) { real r; EACH_LANE LANE(r, w) = sin(LANE(a, w)); return r; }
static inline real lanes_cos(real a) { real r; EACH_LANE LANE(r, w) = cos(LANE(a, w)); return r; }
static inline real lanes_sqrt(real a) { real r; EACH_LANE LANE(r, w) = sqrt(LANE(a, w)); return r; }
static inline real lanes_round(real a) { real r; EACH_LANE LANE(r, w) = round(LANE(a, w)); return r; }
static inline real lanes_atan2(real a, real b) { real r; EACH_LANE LANE(r, w) = atan2(LANE(a, w), LANE(b, w)); return r; }

/* Larger of m and |a|, lane by lane; not-a-number in a is kept. */
static inline real lanes_larger(real m, real a)
{
    real r;
    EACH_LANE { double s = fabs(LANE(a, w)); LANE(r, w) = s <= LANE(m, w) ? LANE(m, w) : s; }
    return r;
}

static inline double largest_lane(real a)
{
    double m = LANE(a, 0);
    EACH_LANE if (!(LANE(a, w) <= m)) m = LANE(a, w);
    return m;
}

static void *cleared(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}
