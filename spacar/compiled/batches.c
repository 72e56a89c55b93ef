/* All elements of a batch at a state, as the NumPy families give them (elements/family.py): arrays have the elements
   last, (rows, n), so that neighbouring elements are the lanes of a vector. In the last vector the last element
   fills up.

   Outputs are (..., n) too. Structural zeros are written. */
static inline void take(real *to, const double *rows, int count, int i, int n)
{
    if (i + LANES <= n) {
        for (int k = 0; k < count; k++) memcpy(&to[k], rows + (size_t)k * n + i, sizeof(real));
        return;
    }
    for (int k = 0; k < count; k++) EACH_LANE LANE(to[k], w) = rows[(size_t)k * n + (i + w < n ? i + w : n - 1)];
}

static inline void give(double *rows, const real *from, int count, int i, int n)
{
    if (i + LANES <= n) {
        for (int k = 0; k < count; k++) memcpy(rows + (size_t)k * n + i, &from[k], sizeof(real));
        return;
    }
    for (int k = 0; k < count; k++) for (int w = 0; i + w < n; w++) rows[(size_t)k * n + i + w] = LANE(from[k], w);
}

#define EACH_VECTOR for (int i = 0; i < k->n; i += LANES)

/* e (nee, n), V (nee, nxe, n); whole turns are those closest to `branch`, row 0 of (nee, n). */
static void spacar_elements_strain(const Elements *k, const double *x, const double *branch, double *e, double *V)
{
    real xe[MAX_X], p[MAX_P], turns[MAX_E], ee[MAX_E], Ve[MAX_E * MAX_X] = {EVERY(0.0)};
    const Batch unwound = {.kind = k->kind, .nee = k->nee};
    EACH_VECTOR {
        take(xe, x, k->nxe, i, k->n);
        take(p, k->p, k->np, i, k->n);
        STRAIN[k->kind](xe, p, ee, Ve);
        if (WHOLE_TURN[k->kind]) { take(turns, branch, 1, i, k->n); unwind(&unwound, xe, turns[0], p, ee); }
        give(e, ee, k->nee, i, k->n);
        give(V, Ve, k->nee * k->nxe, i, k->n);
    }
}

typedef void (*OfVector)(const real *x, const real *v, const real *p, real *out);

/* What a function of the elements gives at x with the vector v (n_v, n): (n_out, n). */
static void with_vector(const Elements *k, OfVector of, const double *x, const double *v, int n_v, double *out,
    int n_out)
{
    real xe[MAX_X], ve[MAX_X], p[MAX_P], values[MAX_X * MAX_X];
    for (int r = 0; r < n_out; r++) values[r] = EVERY(0.0);
    EACH_VECTOR {
        take(xe, x, k->nxe, i, k->n);
        take(ve, v, n_v, i, k->n);
        take(p, k->p, k->np, i, k->n);
        of(xe, ve, p, values);
        give(out, values, n_out, i, k->n);
    }
}

/* Row 0 of `branch` (nee, n), the angle that is counted, at x, e (nee, n). */
static void spacar_elements_angle(const Elements *k, const double *x, const double *e, double *branch)
{
    with_vector(k, ANGLE[k->kind], x, e, k->nee, branch, 1);
}

/* H(v,v) (nee, n). */
static void spacar_elements_convective(const Elements *k, const double *x, const double *v, double *h)
{
    with_vector(k, CONVECTIVE[k->kind], x, v, k->nxe, h, k->nee);
}

/* M (nxe, nxe, n), or NULL, and M a + h (nxe, n), or NULL; a NULL: no accelerations. */
static void spacar_elements_inertia(const Elements *k, const double *x, const double *v, const double *a, double *M,
    double *f)
{
    real xe[MAX_X], ve[MAX_X] = {EVERY(0.0)}, ae[MAX_X], p[MAX_P], fe[MAX_X], flow[MAX_X],
        Me[MAX_X * MAX_X] = {EVERY(0.0)};
    const int n = k->nxe;
    EACH_VECTOR {
        take(xe, x, n, i, k->n);
        if (v) take(ve, v, n, i, k->n);
        take(p, k->p, k->np, i, k->n);
        INERTIA[k->kind](xe, ve, p, Me, fe);
        if (M) give(M, Me, n * n, i, k->n);
        if (!f) continue;
        if (a) {
            take(ae, a, n, i, k->n);
            for (int r = 0; r < n; r++) for (int c = 0; c < n; c++) fe[r] += Me[r * n + c] * ae[c];
        }
        if (FLOW[k->kind]) {
            FLOW[k->kind](xe, ve, p, flow);
            for (int r = 0; r < n; r++) fe[r] += flow[r];
        }
        give(f, fe, n, i, k->n);
    }
}

/* Hs (nxe, nxe, n) of the stresses (nee, n). */
static void spacar_elements_geometric(const Elements *k, const double *x, const double *sigma, double *Hs)
{
    with_vector(k, GEOMETRIC[k->kind], x, sigma, k->nee, Hs, k->nxe * k->nxe);
}

/* H1 (nee, nxe, n), or T where `second`. */
static void spacar_elements_rates(const Elements *k, const double *x, const double *v, int second, double *H1)
{
    with_vector(k, (second ? SECOND_RATES : RATES)[k->kind], x, v, k->nxe, H1, k->nee * k->nxe);
}

/* H2 (nee, nxe, n): of every row Hs v with its unit stress. */
static void spacar_elements_transport(const Elements *k, const double *x, const double *v, double *H2)
{
    real xe[MAX_X], ve[MAX_X], p[MAX_P], s[MAX_E], He[MAX_X * MAX_X] = {EVERY(0.0)}, row[MAX_X];
    const int n = k->nxe;
    EACH_VECTOR {
        take(xe, x, n, i, k->n);
        take(ve, v, n, i, k->n);
        take(p, k->p, k->np, i, k->n);
        for (int r = 0; r < k->nee; r++) {
            for (int other = 0; other < k->nee; other++) s[other] = EVERY((double)(other == r));
            GEOMETRIC[k->kind](xe, s, p, He);
            for (int j = 0; j < n; j++) {
                row[j] = EVERY(0.0);
                for (int c = 0; c < n; c++) row[j] += He[j * n + c] * ve[c];
            }
            give(H2 + (size_t)r * n * k->n, row, n, i, k->n);
        }
    }
}

/* d(M a + h)/dx and dh/dv, (nxe, nxe, n) each. */
static void spacar_elements_inertia_gradient(
    const Elements *k, const double *x, const double *v, const double *a, double *by_x, double *by_v)
{
    real xe[MAX_X], ve[MAX_X], ae[MAX_X], p[MAX_P];
    real both[2 * MAX_X * MAX_X] = {EVERY(0.0)}, flow[2 * MAX_X * MAX_X] = {EVERY(0.0)};
    const int n = k->nxe;
    EACH_VECTOR {
        take(xe, x, n, i, k->n);
        take(ve, v, n, i, k->n);
        take(ae, a, n, i, k->n);
        take(p, k->p, k->np, i, k->n);
        INERTIA_GRADIENT[k->kind](xe, ve, ae, p, both);
        if (FLOW_GRADIENT[k->kind]) {
            FLOW_GRADIENT[k->kind](xe, ve, p, flow);
            for (int r = 0; r < 2 * n * n; r++) both[r] += flow[r];
        }
        for (int r = 0; r < n; r++) {
            give(by_x + (size_t)r * n * k->n, both + 2 * r * n, n, i, k->n);
            give(by_v + (size_t)r * n * k->n, both + (2 * r + 1) * n, n, i, k->n);
        }
    }
}

/* Smallest guard of all elements at x; 1 when there are none. */
static double spacar_elements_guard(const Elements *k, const double *x)
{
    real xe[MAX_X], p[MAX_P], g[MAX_GUARDS];
    double least = 1.0;
    EACH_VECTOR {
        if (!N_GUARDS[k->kind]) break;
        take(xe, x, k->nxe, i, k->n);
        take(p, k->p, k->np, i, k->n);
        GUARD[k->kind](xe, p, g);
        for (int r = 0; r < N_GUARDS[k->kind]; r++) EACH_LANE if (!(LANE(g[r], w) >= least)) least = LANE(g[r], w);
    }
    return least;
}
