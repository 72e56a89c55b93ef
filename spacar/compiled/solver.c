/* One evaluation of the equations of motion of a holonomic mechanism, dense storage (theory-system.md (1), (2), (9)).

   Included behind kernels.c. All vectors are in the order of the result files; matrices are row by row. */
#include <stdlib.h>
#include <string.h>

enum { PLBEAM, PLTRUSS, PLTOR, PLPINBOD, BEAM, TRUSS, HINGE, PINBODY, NORMALIZATION, BODY };
enum { OK = 0, NO_CONVERGENCE = -1, SINGULAR = -2, NOT_FINITE = -3, JUMP = -4 };
enum { MAX_ITERATIONS = 20, MAX_X = 14, MAX_E = 6 };

typedef struct {
    int kind, n, nxe, nee, np, inertia; /* inertia: M and h depend on x */
    const int *x, *e;                   /* (n, nxe), (n, nee) */
    const double *p;                    /* (n, np) */
} Batch;

typedef struct {
    int nx, ne, n_fixed_x, n_rows, n_equations, n_batches, n_stiffness, n_damping, prescribed;
    const Batch *batches;
    const double *constant_mass;          /* (nx, nx) */
    const double *scale, *force, *field;  /* (nx) sizes, constant forces without gravity, gravity field */
    const double *preload;                /* (ne) */
    const int *s_rows, *s_columns, *d_rows, *d_columns;
    const double *s_values, *d_values;
    const int *free;                      /* (n_free) coordinates that are not fixed or prescribed */
    int n_free;
    double mass_scale;
    double *V, *M, *A, *h, *convected, *work; /* (ne,nx) (nx,nx) (n,n) (ne) (nx) (2n + nx) */
    int *pivot;
} Model;

/* LU with partial pivoting in place; rows are scaled implicitly by their largest entry. 0 or SINGULAR. Most entries are zero:
   the columns of a pivot row that are not are collected first. */
static int factor(double *A, int n, int *pivot, double *weight)
{
    int column[n];
    for (int i = 0; i < n; i++) {
        double m = 0.0;
        for (int j = 0; j < n; j++) if (fabs(A[i * n + j]) > m) m = fabs(A[i * n + j]);
        if (!(m > 0.0)) return SINGULAR;
        weight[i] = 1.0 / m;
    }
    for (int k = 0; k < n; k++) {
        int best = k;
        double largest = 0.0;
        for (int i = k; i < n; i++) {
            double size = fabs(A[i * n + k]) * weight[i];
            if (size > largest) { largest = size; best = i; }
        }
        if (!(largest > 0.0)) return SINGULAR;
        pivot[k] = best;
        if (best != k) {
            for (int j = 0; j < n; j++) { double t = A[k * n + j]; A[k * n + j] = A[best * n + j]; A[best * n + j] = t; }
            weight[best] = weight[k];
        }
        const double *row = A + k * n, inverse = 1.0 / row[k];
        int filled = 0;
        for (int j = k + 1; j < n; j++) if (row[j] != 0.0) column[filled++] = j;
        for (int i = k + 1; i < n; i++) {
            double *below = A + i * n;
            if (below[k] == 0.0) continue;
            const double l = below[k] *= inverse;
            for (int j = 0; j < filled; j++) below[column[j]] -= l * row[column[j]];
        }
    }
    return OK;
}

static void solve(const double *A, int n, const int *pivot, double *b)
{
    for (int k = 0; k < n; k++) { double t = b[k]; b[k] = b[pivot[k]]; b[pivot[k]] = t; }
    for (int i = 0; i < n; i++) for (int j = 0; j < i; j++) b[i] -= A[i * n + j] * b[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) b[i] -= A[i * n + j] * b[j];
        b[i] /= A[i * n + i];
    }
}

static void solve_transposed(const double *A, int n, const int *pivot, double *b)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) b[i] -= A[j * n + i] * b[j];
        b[i] /= A[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) for (int j = i + 1; j < n; j++) b[i] -= A[j * n + i] * b[j];
    for (int k = n - 1; k >= 0; k--) { double t = b[k]; b[k] = b[pivot[k]]; b[pivot[k]] = t; }
}

static void element_strain(int kind, const double *x, const double *p, double *e, double *V)
{
    switch (kind) {
    case PLBEAM: plbeam_strain(x, p, e, V); break;
    case PLTRUSS: pltruss_strain(x, p, e, V); break;
    case PLTOR: pltor_strain(x, p, e, V); break;
    case PLPINBOD: plpinbod_strain(x, p, e, V); break;
    case BEAM: beam_strain(x, p, e, V); break;
    case TRUSS: truss_strain(x, p, e, V); break;
    case HINGE: hinge_strain(x, p, e, V); break;
    case PINBODY: pinbody_strain(x, p, e, V); break;
    case NORMALIZATION: normalization_strain(x, p, e, V); break;
    }
}

static void element_convective(int kind, const double *x, const double *v, const double *p, double *h)
{
    switch (kind) {
    case PLBEAM: plbeam_convective(x, v, p, h); break;
    case PLTRUSS: pltruss_convective(x, v, p, h); break;
    case PLTOR: pltor_convective(x, v, p, h); break;
    case PLPINBOD: plpinbod_convective(x, v, p, h); break;
    case BEAM: beam_convective(x, v, p, h); break;
    case TRUSS: truss_convective(x, v, p, h); break;
    case HINGE: hinge_convective(x, v, p, h); break;
    case PINBODY: pinbody_convective(x, v, p, h); break;
    case NORMALIZATION: normalization_convective(x, v, p, h); break;
    }
}

static void strain(const Model *m, const double *x, const double *near, double *e)
{
    double xe[MAX_X], ee[MAX_E], Ve[MAX_E * MAX_X];
    for (int b = 0; b < m->n_batches; b++) {
        const Batch *k = &m->batches[b];
        if (k->kind == BODY) continue;
        for (int i = 0; i < k->n; i++) {
            const int *ix = k->x + i * k->nxe, *ie = k->e + i * k->nee;
            for (int j = 0; j < k->nxe; j++) xe[j] = x[ix[j]];
            memset(Ve, 0, sizeof(double) * k->nee * k->nxe);
            element_strain(k->kind, xe, k->p + i * k->np, ee, Ve);
            if (k->kind == HINGE) ee[0] += 2 * M_PI * round((near[ie[0]] - ee[0]) / (2 * M_PI));
            for (int r = 0; r < k->nee; r++) {
                e[ie[r]] = ee[r];
                for (int j = 0; j < k->nxe; j++) m->V[ie[r] * m->nx + ix[j]] = Ve[r * k->nxe + j];
            }
        }
    }
}

static void inertia(const Model *m, const double *x, const double *v)
{
    double xe[MAX_X], ve[MAX_X], he[MAX_X], Me[MAX_X * MAX_X];
    memcpy(m->M, m->constant_mass, sizeof(double) * m->nx * m->nx);
    memset(m->convected, 0, sizeof(double) * m->nx);
    for (int b = 0; b < m->n_batches; b++) {
        const Batch *k = &m->batches[b];
        for (int i = 0; i < k->n; i++) {
            const int *ix = k->x + i * k->nxe;
            const double *p = k->p + i * k->np;
            for (int j = 0; j < k->nxe; j++) { xe[j] = x[ix[j]]; ve[j] = v[ix[j]]; }
            if (k->nee) {
                double rates[MAX_E];
                element_convective(k->kind, xe, ve, p, rates);
                for (int r = 0; r < k->nee; r++) m->h[k->e[i * k->nee + r]] = rates[r];
            }
            if (!k->inertia) continue;
            memset(Me, 0, sizeof Me);
            if (k->kind == PLBEAM) plbeam_inertia(xe, ve, p, Me, he);
            else if (k->kind == BEAM) beam_inertia(xe, ve, p, Me, he);
            else body_inertia(xe, ve, p, Me, he);
            for (int r = 0; r < k->nxe; r++) {
                m->convected[ix[r]] += he[r];
                for (int j = 0; j < k->nxe; j++) m->M[ix[r] * m->nx + ix[j]] += Me[r * k->nxe + j];
            }
        }
    }
}

/* Position and velocity. x comes with the given values and a guess of the calculable ones, xd and ed with the given rates. */
static int place(const Model *m, double *x, double *xd, double *e, const double *near, const double *e_given,
                 const double *e_rate, double converged)
{
    const int n = m->n_equations, first = m->n_fixed_x, nx = m->nx;
    double *r = m->work, *v = m->work + n, *weight = m->work + 2 * n;
    double before = INFINITY;
    int halvings = 0;
    for (int iteration = 1; iteration <= MAX_ITERATIONS; iteration++) {
        strain(m, x, near, e);
        double norm = 0.0;
        for (int i = 0; i < n; i++) {
            double residual = e[i] - e_given[i];
            if (!isfinite(residual)) return NOT_FINITE;
            if (fabs(residual) > norm) norm = fabs(residual);
        }
        if (norm > 2.0 * before && norm > 1e-6) {
            if (++halvings > 5) return NO_CONVERGENCE;
            for (int i = 0; i < n; i++) { r[i] *= 0.5; x[first + i] += r[i]; }
            continue;
        }
        before = norm;
        halvings = 0;
        for (int i = 0; i < n; i++) {
            const double *row = m->V + i * nx;
            double rate = 0.0;
            for (int j = 0; j < first; j++) rate += row[j] * xd[j];
            for (int j = first + n; j < nx; j++) rate += row[j] * xd[j];
            r[i] = e[i] - e_given[i];
            v[i] = e_rate[i] - rate;
            memcpy(m->A + i * n, row + first, sizeof(double) * n);
        }
        if (factor(m->A, n, m->pivot, weight)) return SINGULAR;
        solve(m->A, n, m->pivot, r);
        solve(m->A, n, m->pivot, v);
        double step = 0.0;
        for (int i = 0; i < n; i++) {
            x[first + i] -= r[i];
            xd[first + i] = v[i];
            double size = fabs(r[i]) / m->scale[first + i];
            if (!(size <= step)) step = size;
        }
        if (!isfinite(step)) return NOT_FINITE;
        if (step <= converged) return iteration;
    }
    return NO_CONVERGENCE;
}

static void stresses(const Model *m, const double *e, const double *xd, double *sigma)
{
    memcpy(sigma, m->preload, sizeof(double) * m->ne);
    for (int i = 0; i < m->n_stiffness; i++) sigma[m->s_rows[i]] += m->s_values[i] * e[m->s_columns[i]];
    for (int i = 0; i < m->n_damping; i++) {
        const double *row = m->V + m->d_columns[i] * m->nx;
        double rate = 0.0;
        for (int j = 0; j < m->nx; j++) rate += row[j] * xd[j];
        sigma[m->d_rows[i]] += m->d_values[i] * rate;
    }
}

/* Right-hand side f + M g - h - M xdd_given - V^T sigma at every coordinate, into out (nx). */
static void out_of_balance(const Model *m, const double *xdd, const double *sigma, int first_row, double *out)
{
    const int nx = m->nx;
    for (int i = 0; i < nx; i++) {
        double sum = m->force[i] - m->convected[i];
        for (int j = 0; j < nx; j++) sum += m->M[i * nx + j] * (m->field[j] - xdd[j]);
        out[i] = sum;
    }
    for (int r = first_row; r < m->ne; r++)
        if (sigma[r] != 0.0)
            for (int j = 0; j < nx; j++) out[j] -= m->V[r * nx + j] * sigma[r];
}

/* xdd comes with the given accelerations (zero elsewhere); sigma, xdd are completed. The position system must be factored. */
static int accelerate(const Model *m, const double *x, const double *xd, const double *e, const double *edd_given,
                      double *xdd, double *sigma)
{
    const int nx = m->nx, n = m->n_equations, nf = m->n_free, nr = m->n_rows, N = nf + nr;
    inertia(m, x, xd);
    stresses(m, e, xd, sigma);
    double *b = m->work;
    if (m->prescribed) { /* no dynamic degree of freedom: kinematics, then reactions from the transposed system */
        for (int i = 0; i < n; i++) {
            double sum = edd_given[i] - m->h[i];
            for (int j = 0; j < nx; j++) sum -= m->V[i * nx + j] * xdd[j];
            b[i] = sum;
        }
        solve(m->A, n, m->pivot, b);
        memcpy(xdd + m->n_fixed_x, b, sizeof(double) * n);
        double *force = m->work + 2 * n;
        out_of_balance(m, xdd, sigma, n, force);
        memcpy(b, force + m->n_fixed_x, sizeof(double) * n);
        solve_transposed(m->A, n, m->pivot, b);
        memcpy(sigma, b, sizeof(double) * n);
        return OK;
    }
    double *force = m->work + 2 * N;
    out_of_balance(m, xdd, sigma, nr, force);
    memset(m->A, 0, sizeof(double) * N * N);
    for (int i = 0; i < nf; i++) {
        b[i] = force[m->free[i]];
        for (int j = 0; j < nf; j++) m->A[i * N + j] = m->M[m->free[i] * nx + m->free[j]];
    }
    for (int r = 0; r < nr; r++) {
        const double *row = m->V + r * nx;
        double sum = edd_given[r] - m->h[r];
        for (int j = 0; j < nx; j++) sum -= row[j] * xdd[j];
        b[nf + r] = sum * m->mass_scale;
        for (int j = 0; j < nf; j++) m->A[(nf + r) * N + j] = m->A[j * N + nf + r] = row[m->free[j]] * m->mass_scale;
    }
    if (factor(m->A, N, m->pivot, m->work + N)) return SINGULAR;
    solve(m->A, N, m->pivot, b);
    for (int i = 0; i < nf; i++) {
        if (!isfinite(b[i])) return NOT_FINITE;
        xdd[m->free[i]] = b[i];
    }
    for (int r = 0; r < nr; r++) sigma[r] = b[nf + r] * m->mass_scale;
    return OK;
}

typedef struct {
    int x_input, n_x_input, x_dynamic, n_x_dynamic, e_input, n_e_input, e_dynamic, n_e_dynamic, polynomial, known;
    double t;                             /* of the last evaluated state, when `known` */
    const double *x0;                     /* (nx) reference configuration: the values of fixed coordinates */
    const double *x_motion, *e_motion;    /* (n, 3): start, rate, acceleration; or value, rate, acceleration at t */
    double *x, *xd, *xdd;                 /* (nx) last evaluated state */
    double *given_e, *given_ed, *given_edd, *near, *e, *ed, *edd, *sigma; /* (ne) */
    double *next_x, *next_xd, *next_xdd;  /* (nx) work */
} State;

/* Value, rate and acceleration of a prescribed motion. */
static void motion(const State *s, const double *row, double t, double *value, double *rate, double *acceleration)
{
    *value = s->polynomial ? row[0] + t * (row[1] + 0.5 * t * row[2]) : row[0];
    *rate = s->polynomial ? row[1] + t * row[2] : row[1];
    *acceleration = row[2];
}

/* Evaluate the state y = (x dynamic, e dynamic, their rates) at t. Number of position iterations, or a negative reason; then
   the last evaluated state is still there. The guess of the position is the Taylor expansion of the last state. */
int spacar_evaluate(const Model *m, State *s, double t, const double *y, double converged, double jump)
{
    const int nx = m->nx, first = m->n_fixed_x, n = m->n_equations, a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    double *x = s->next_x, *xd = s->next_xd, *xdd = s->next_xdd;
    const double dt = s->known ? t - s->t : 0.0;
    memcpy(x, s->x0, sizeof(double) * nx);
    memset(xd, 0, sizeof(double) * nx);
    memset(xdd, 0, sizeof(double) * nx);
    for (int i = first; i < first + n; i++) x[i] = s->x[i] + dt * (s->xd[i] + 0.5 * dt * s->xdd[i]);
    for (int i = 0; i < s->n_x_input; i++) {
        const int k = s->x_input + i;
        motion(s, s->x_motion + 3 * i, t, &x[k], &xd[k], &xdd[k]);
    }
    for (int i = 0; i < s->n_e_input; i++) {
        const int k = s->e_input + i;
        motion(s, s->e_motion + 3 * i, t, &s->given_e[k], &s->given_ed[k], &s->given_edd[k]);
    }
    for (int i = 0; i < a; i++) { x[s->x_dynamic + i] = y[i]; xd[s->x_dynamic + i] = y[q + i]; }
    for (int i = a; i < q; i++) {
        s->given_e[s->e_dynamic + i - a] = y[i];
        s->given_ed[s->e_dynamic + i - a] = y[q + i];
    }
    memcpy(s->near, s->e, sizeof(double) * m->ne);
    memcpy(s->near, s->given_e, sizeof(double) * n); /* the rows that are given come first */
    const int iterations = place(m, x, xd, s->edd, s->near, s->given_e, s->given_ed, converged);
    if (iterations < 0) return iterations;
    for (int i = 0; i < nx; i++) if (!(fabs(x[i] - s->x[i]) <= jump * m->scale[i])) return JUMP;
    const int status = accelerate(m, x, xd, s->edd, s->given_edd, xdd, s->sigma);
    if (status < 0) return status;
    memcpy(s->e, s->edd, sizeof(double) * m->ne);
    memcpy(s->x, x, sizeof(double) * nx);
    memcpy(s->xd, xd, sizeof(double) * nx);
    memcpy(s->xdd, xdd, sizeof(double) * nx);
    s->t = t;
    s->known = 1;
    for (int r = 0; r < m->ne; r++) {
        double rate = 0.0, acceleration = m->h[r];
        for (int j = 0; j < nx; j++) {
            rate += m->V[r * nx + j] * xd[j];
            acceleration += m->V[r * nx + j] * xdd[j];
        }
        s->ed[r] = rate;
        s->edd[r] = acceleration;
    }
    return iterations;
}

/* Time derivative of y. */
int spacar_rhs(const Model *m, State *s, double t, const double *y, double *out, double converged, double jump)
{
    const int status = spacar_evaluate(m, s, t, y, converged, jump);
    if (status < 0) return status;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    memcpy(out, y + q, sizeof(double) * q);
    memcpy(out + q, s->xdd + s->x_dynamic, sizeof(double) * a);
    memcpy(out + q + a, s->edd + s->e_dynamic, sizeof(double) * s->n_e_dynamic);
    return status;
}

/* Gravity M g and total external forces M xdd + h + V^T sigma at the last evaluated state. */
void spacar_forces(const Model *m, const double *xdd, const double *sigma, double *gravity, double *total)
{
    const int nx = m->nx;
    for (int i = 0; i < nx; i++) {
        double g = 0.0, sum = m->convected[i];
        for (int j = 0; j < nx; j++) { g += m->M[i * nx + j] * m->field[j]; sum += m->M[i * nx + j] * xdd[j]; }
        gravity[i] = g;
        total[i] = sum;
    }
    for (int r = 0; r < m->ne; r++)
        for (int j = 0; j < nx; j++) total[j] += m->V[r * nx + j] * sigma[r];
}
