/* Along the equilibrium path over levels, as long as nothing there needs a decision: spacar/stationary/continuation.py, which gives the constants
   and goes on where this ends. A level is passed when Newton's iteration finds the state from the prediction, the path is not much faster
   than before or the iteration at the level before leads back, and the state is proved to be stable. */
enum { REMEMBERED = 4 }; /* states that predict the next one, as in passed_levels.py */

typedef struct {
    const double *levels;      /* (count, 5): fractions of both parts of the loading, part of the forces that are held, place on the way, stored? */
    double *states, *places;   /* (REMEMBERED, nx + ne): x, sigma of the last states, (REMEMBERED): where they are; the last is the latest */
    double *branch, *trial;      /* (ne) of the sweep: at the last state, at the one that is tried */
    int64_t count, known, passed, iterations;
    double wide, faster, farthest, critical, returned, elsewhere, noise; /* noise: of the last state */
    double demands[2][4];      /* of a level that is passed only, of one that is stored: forces, lengths, correction, tolerance */
} Passed;

/* Lagrange's polynomial through the last states at a place, of fewer where they are close together. The first `fixed` coordinates stay. */
static void predict(const Passed *p, int size, double place, double *x, int nx, int fixed, double *sigma)
{
    double weights[REMEMBERED], most;
    int n = (int)p->known;
    const double *at;
    for (;; n--) {
        at = p->places + REMEMBERED - n;
        most = 0.0;
        for (int i = 0; i < n; i++) {
            weights[i] = 1.0;
            for (int j = 0; j < n; j++) if (j != i) weights[i] *= (place - at[j]) / (at[i] - at[j]);
            most = larger(most, weights[i]);
        }
        if (n == 1 || most <= p->farthest) break;
    }
    const double *states = p->states + (size_t)(REMEMBERED - n) * size;
    memcpy(x, p->states + (size_t)(REMEMBERED - 1) * size, sizeof(double) * fixed);
    for (int c = fixed; c < size; c++) {
        double sum = 0.0;
        for (int i = 0; i < n; i++) sum += weights[i] * states[(size_t)i * size + c];
        *(c < nx ? x + c : sigma + c - nx) = sum;
    }
}

static double way(const Equilibrium *q, const double *a, const double *b)
{
    double size = 0.0;
    for (int i = 0; i < q->nx; i++) size = larger(size, (a[i] - b[i]) / q->scale[i]);
    return size;
}

static void take_level(Equilibrium *q, const double *level, const double *demand)
{
    q->parts[0] = level[0]; q->parts[1] = level[1]; q->hold = level[2];
    q->forces = demand[0]; q->lengths = demand[1]; q->correction = demand[2]; q->tolerance = demand[3];
}

/* Does the iteration at the level before not lead from the state in q->x, q->sigma to another one than the last? One that goes astray tells
   nothing. */
static int leads_back(Equilibrium *q, const Passed *p, const double *reached, const double *last, double moved)
{
    const Own *w = q->own;
    const double demand[4] = { INFINITY, INFINITY, p->returned * moved, INFINITY };
    memcpy(p->trial, q->branch, sizeof(double) * q->ne);
    take_level(q, reached, demand);
    const int status = spacar_equilibrium_newton(q);
    memcpy(q->branch, p->trial, sizeof(double) * q->ne);
    return status != ANOTHER_WAY && !(status == FOUND && way(q, w->x, last) > p->elsewhere * moved);
}

static void spacar_equilibrium_walk(Equilibrium *q, Passed *p)
{
    const Own *w = q->own;
    const int nx = (int)q->nx, ne = (int)q->ne, size = nx + ne;
    const double start[5] = { q->parts[0], q->parts[1], q->hold, 0.0, 0.0 }, *reached = start;
    double *last = p->states + (size_t)(REMEMBERED - 1) * size, *at = p->places + REMEMBERED - 1;
    double change = p->known > 1 ? way(q, last, last - size) : 0.0;
    p->passed = p->iterations = 0;
    for (const double *level = p->levels; p->passed < p->count; level += 5) {
        const double *demand = p->demands[level[4] != 0.0];
        memcpy(p->branch, q->branch, sizeof(double) * ne);
        take_level(q, level, demand);
        predict(p, size, level[3], q->x, nx, (int)q->x_free, q->sigma);
        if (spacar_equilibrium_newton(q) != FOUND || !q->iterations || !(q->noise <= p->critical)) break;
        const int64_t iterations = q->iterations;
        const double noise = q->noise, moved = way(q, w->x, last);
        const int steady = p->known > 1 && moved * (at[0] - at[-1]) <= p->faster * change * (level[3] - at[0]);
        memcpy(q->x, w->x, sizeof(double) * nx);
        memcpy(q->sigma, w->sigma, sizeof(double) * ne);
        if (!(moved < p->wide || steady)) {
            if (!leads_back(q, p, reached, last, moved)) break;
            take_level(q, level, demand);
        }
        if (!spacar_equilibrium_definite(q)) break;
        memmove(p->states, p->states + size, sizeof(double) * (REMEMBERED - 1) * size);
        memmove(p->places, p->places + 1, sizeof(double) * (REMEMBERED - 1));
        memcpy(last, q->x, sizeof(double) * nx);
        memcpy(last + nx, q->sigma, sizeof(double) * ne);
        *at = level[3];
        if (p->known < REMEMBERED) p->known++;
        rest_follow(q, w);
        memcpy(p->branch, q->branch, sizeof(double) * ne);
        change = moved;
        reached = level;
        p->iterations += iterations;
        p->noise = noise;
        p->passed++;
    }
    memcpy(q->branch, p->branch, sizeof(double) * ne);
    take_level(q, reached, p->demands[0]);
    if (!p->passed) return;
    memcpy(q->x, last, sizeof(double) * nx);
    memcpy(q->sigma, last + nx, sizeof(double) * ne);
    spacar_equilibrium_point(q);
}
