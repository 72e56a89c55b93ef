/* Simplified Newton iteration of codes 553 and 595, as `_newton` of spacar/integrators/radau.py; see there for
   formulas and sources. One case; the LU factors are those of LAPACK (columns first, row i exchanged with pivots[i],
   counted from 0). */
enum { MOST_STAGES = 5 };

static void solve_real(const double *lu, const int *pivots, int n, double *b)
{
    for (int i = 0; i < n; i++) { const double kept = b[i]; b[i] = b[pivots[i]]; b[pivots[i]] = kept; }
    for (int j = 0; j < n; j++) for (int i = j + 1; i < n; i++) b[i] -= lu[i + (size_t)j * n] * b[j];
    for (int j = n - 1; j >= 0; j--) {
        b[j] /= lu[j + (size_t)j * n];
        for (int i = 0; i < j; i++) b[i] -= lu[i + (size_t)j * n] * b[j];
    }
}

/* x + i y in two rows. */
static void solve_complex(const double *lu, const int *pivots, int n, double *x, double *y)
{
    for (int i = 0; i < n; i++) {
        const int k = pivots[i];
        const double a = x[i], b = y[i];
        x[i] = x[k]; y[i] = y[k]; x[k] = a; y[k] = b;
    }
    for (int j = 0; j < n; j++) {
        const double *column = lu + 2 * (size_t)j * n, a = x[j], b = y[j];
        for (int i = j + 1; i < n; i++) {
            x[i] -= column[2 * i] * a - column[2 * i + 1] * b;
            y[i] -= column[2 * i] * b + column[2 * i + 1] * a;
        }
    }
    for (int j = n - 1; j >= 0; j--) {
        const double *column = lu + 2 * (size_t)j * n, p = column[2 * j], q = column[2 * j + 1], d = p * p + q * q;
        const double a = (x[j] * p + y[j] * q) / d, b = (y[j] * p - x[j] * q) / d;
        x[j] = a; y[j] = b;
        for (int i = 0; i < j; i++) {
            x[i] -= column[2 * i] * a - column[2 * i + 1] * b;
            y[i] -= column[2 * i] * b + column[2 * i + 1] * a;
        }
    }
}

/* A row of s numbers times a column, whose numbers are `stride` apart. */
static inline double product(const double *row, const double *column, int s, int stride)
{
    double sum = 0.0;
    for (int l = 0; l < s; l++) sum += row[l] * column[l * stride];
    return sum;
}

/* The stages Z from their guess. */
static int spacar_newton(Model *m, State *at, Newton *r)
{
#if LANES == 1
    const int s = r->s, n = r->n, nq = r->nq, nu = n - nq, v = n - nq;
    const double estimate = r->contraction, h = r->h;
    double *stage = m->stage, before = 0.0;
    for (r->iterations = 0; r->iterations < r->most;) {
        const int k = r->iterations++;
        for (int i = 0; i < s; i++) {
            for (int j = 0; j < n; j++) stage[j] = r->y[j] + r->Z[i * n + j];
            const double time = fmin(fmax(r->t + r->c[i] * h, r->earliest), r->latest);
            double *f = r->F + (size_t)i * n, sum = 0.0;
            if (spacar_rhs(m, at, time, stage, f, r->converged, r->jump) < 0) return NO_RATE;
            r->n_rhs++;
            for (int j = 0; j < n; j++) sum += f[j];
            if (!isfinite(sum)) return NO_RATE;
        }
        double *left = r->change; /* F - a^-1 Z / h, nu of each row of n */
        for (int i = 0; i < s; i++)
            for (int j = 0; j < nu; j++)
                left[i * n + j] = r->F[i * n + nq + j] - product(r->inverse + i * s, r->Z + nq + j, s, n) / h;
        for (int i = 0; i < s; i++)
            for (int j = 0; j < nu; j++) r->right[i * nu + j] = product(r->to + i * s, left + j, s, n);
        solve_real(r->lu, r->pivots, nu, r->right);
        for (int p = 0; 2 * p + 2 < s; p++)
            solve_complex(r->pair_lu[p], r->pair_pivots[p], nu, r->right + (2 * p + 1) * nu,
                r->right + (2 * p + 2) * nu);
        for (int i = 0; i < s; i++)
            for (int j = 0; j < nu; j++) r->change[i * n + nq + j] = product(r->back + i * s, r->right + j, s, nu);
        for (int i = 0; i < s; i++) /* the positions follow the velocities, whatever they were before */
            for (int j = 0; j < nq; j++) {
                double sum = 0.0;
                for (int l = 0; l < s; l++) sum += r->a[i * s + l] * (r->Z[l * n + v + j] + r->change[l * n + v + j]);
                r->change[i * n + j] = h * (r->c[i] * r->y[v + j] + sum) - r->Z[i * n + j];
            }
        double sum = 0.0;
        for (int i = 0; i < s; i++)
            for (int j = 0; j < n; j++) {
                const double d = r->change[i * n + j], scaled = d / r->weight[j];
                sum += scaled * scaled;
                r->Z[i * n + j] += d;
            }
        before = r->size;
        r->size = sqrt(sum / (s * n));
        if (k) {
            const double theta = r->contraction = r->size / before;
            if (!(theta < 0.99) || r->size * pow(theta, r->most - 1 - k) > r->kappa * (1.0 - theta)) {
                r->theta = theta;
                return NOT_CONVERGED;
            }
            if (r->size * theta <= r->kappa * (1.0 - theta)) return ITERATED;
            r->theta = theta;
        }
        else if (r->size * estimate <= r->kappa * (1.0 - estimate)) return ITERATED;
    }
    return NOT_CONVERGED;
#else
    return NO_RATE;
#endif
}
