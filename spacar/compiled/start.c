/* The start of a motion: the first state, and whether its reduced mass matrix can be doubted
   (spacar/dynamics/mass_check.py). */

/* Does the first look of mass_check.py leave a doubt in a lane? M (q, q), condition: of D, largest: diagonal entry
   of the mass matrix in the sizes of the coordinates; d, L: room for q and q^2. The eigenvalues of M scaled to a
   unit diagonal are above tau where M - tau has a Cholesky factorization (known to q eps, as they are). */
static int is_doubtful(const Model *m, const real *M, int w, double condition, double largest, double *d, double *L)
{
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, q = a + s->n_e_dynamic;
    const double half = sqrt(DBL_EPSILON), part = 8.0 * s->nx * DBL_EPSILON * condition * condition,
        rounding = part * part * largest;
    double least = INFINITY;
    for (int i = 0; i < q; i++) {
        const double size = i < a ? s->scale[s->x_dynamic + i] : s->e_scale[s->e_dynamic + i - a];
        d[i] = LANE(M[i * q + i], w);
        if (!(d[i] * size * size >= least)) least = d[i] * size * size; /* not a number stays */
    }
    if (!(least > fmax(fmax(half * largest, rounding), 0.0))) return 1;
    const double tau = fmax(half, rounding / least);
    for (int i = 0; i < q; i++)
        for (int j = 0; j <= i; j++) {
            double sum = i == j ? 1.0 - tau : LANE(M[i * q + j], w) / sqrt(d[i] * d[j]);
            for (int k = 0; k < j; k++) sum -= L[i * q + k] * L[j * q + k];
            if (i == j && !(sum > 0.0)) return 1;
            L[i * q + j] = i == j ? sqrt(sum) : sum / L[j * q + j];
        }
    return 0;
}

/* The same of all lanes at the last evaluated state. A bound of the condition comes first: it is enough where masses
   are ordinary. */
static int is_mass_doubtful(Model *m)
{
    const Spec *s = &m->s;
    const int q = s->n_x_dynamic + s->n_e_dynamic;
    Memory work = {0};
    real *M = cleared(&work, (size_t)q * q + s->nx, sizeof(real)), *diagonal = M + q * q;
    double *d = cleared(&work, (size_t)q * q + q, sizeof(double));
    int doubt = !M || !d || !spacar_reduced_mass(m, M);
    if (!doubt) {
        for (int k = 0; k < m->mass.n; k++)
            if (m->mass.row[k] == m->mass.column[k]) diagonal[m->mass.row[k]] += m->values[m->mass.source[k]];
        for (int exact = 0; exact < 2; exact++) {
            const double condition = 1.0 / spacar_rcond(m, exact ? INFINITY : 0.0, INT_MAX);
            doubt = 0;
            EACH_LANE {
                double largest = 0.0;
                for (int i = 0; i < s->nx; i++)
                    largest = fmax(largest, LANE(diagonal[i], w) * s->scale[i] * s->scale[i]);
                doubt |= is_doubtful(m, M, w, condition, largest, d, d + q);
            }
            if (!doubt) break;
        }
    }
    give_back(&work);
    return doubt;
}

/* Evaluate the start state y (its time derivative into out) from the configuration of `at`. A negative reason when
   that is not possible; FAR_AWAY when a coordinate moves by more than `farthest` of its size, or the determinant of
   the position matrix changes its sign, so that the path has to be followed; with `checked`, DOUBTFUL_MASS when the
   mass matrix is to be looked at closely; else OK. */
static int spacar_start(Model *m, State *at, const real *y, real *out, double converged, double jump, double farthest,
    int checked)
{
    const Spec *s = &m->s;
    const real *x0 = s->x0;
    double before[LANES], after[LANES], exponent[LANES];
    follow(m, at->x, at->e, m->branch);
    const int placed = !m->tree && !strain(m, at->x, m->branch, m->next_e) && !factor(&m->position, m->values);
    if (placed) determinant(&m->position, before, exponent);
    m->factored = 0;
    const int status = spacar_evaluate(m, at, 0.0, y, converged, jump);
    if (status < 0) return status;
    if (placed) {
        determinant(&m->position, after, exponent);
        EACH_LANE if (before[w] * after[w] < 0.0) return FAR_AWAY;
    }
    rates_of_whole(m, at, out);
    real moved = EVERY(0.0);
    for (int i = 0; i < s->nx; i++) moved = lanes_larger(moved, (at->x[i] - x0[i]) / s->scale[i]);
    if (!m->tree && !(largest_lane(moved) <= farthest)) return FAR_AWAY;
    return checked && is_mass_doubtful(m) ? DOUBTFUL_MASS : OK;
}

/* A state at the reference configuration that nothing is known of, in memory for x, xd, xdd and three forces (nx),
   e, ed, edd, sigma, given_e (ne), y. */
static void spacar_state(const Model *m, State *at, real *memory)
{
    const int nx = m->s.nx, ne = m->s.ne;
    memset(memory, 0, sizeof(real) * (6 * nx + 5 * ne + n_of_state(&m->s)));
    real **of_x[] = {&at->x, &at->xd, &at->xdd, &at->applied, &at->gravity, &at->total};
    for (int k = 0; k < 6; k++, memory += nx) *of_x[k] = memory;
    real **of_e[] = {&at->e, &at->ed, &at->edd, &at->sigma, &at->given_e};
    for (int k = 0; k < 5; k++, memory += ne) *of_e[k] = memory;
    at->y = memory;
    at->known = at->whole = 0;
    at->t = 0.0;
    clear_samples(at);
    memcpy(at->x, m->s.x0, sizeof(real) * nx);
}
