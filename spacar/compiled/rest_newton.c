/* Newton's iteration on the mixed equations at rest, and what is asked of its matrix. Formulas and criteria:
   spacar/stationary/newton.py, tangent.py. */

/* The tangent at the last residual, factored. */
static int rest_factor(const Equilibrium *q, Own *w, const double *sigma)
{
    if (!rest_blocks(q, w, sigma)) return ANOTHER_WAY;
    memset(w->band, 0, sizeof(double) * w->n * (3 * (size_t)w->b + 1));
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        if (g->curved) for (int i = 0; i < p->square; i++) if (p->at[i] >= 0) w->band[p->at[i]] += p->H[i];
        if (g->heavy) for (int i = 0; i < p->square; i++) if (p->at[i] >= 0) w->band[p->at[i]] += p->by_x[i];
        const int nxe = g->elements->nxe, nee = g->elements->nee, m = g->elements->n;
        for (int r = 0, at = 0; r < nee; r++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++, at++) {
            if (p->v_at[at] < 0) continue;
            const double value = q->size * w->coupled[g->e[r * m + i]] * g->V[at];
            w->band[p->v_at[at]] += value;
            w->band[p->turned_at[at]] += value;
        }
        for (int i = 0; i < p->c; i++) if (p->c_at[i] >= 0) w->band[p->c_at[i]] -= q->size * p->C[i];
    }
    w->factored = band_factor(w->band, w->n, w->b, w->pivots) == OK;
    return w->factored ? OK : ANOTHER_WAY;
}

/* Correction of the last residual, in dx and z, where dx holds the changes of prescribed coordinates. ANOTHER_WAY:
   singular. */
static int rest_correct(Equilibrium *q, Own *w, int prescribed, double *noise)
{
    const int n = w->n, nf = (int)q->nf;
    double *extra = w->lengths; /* not needed any more */
    if (prescribed) { /* the matrix times dx */
        memset(w->force, 0, sizeof(double) * q->nx);
        memset(extra, 0, sizeof(double) * q->ne);
        for (int k = 0; k < q->n_groups; k++) {
            const Group *g = &q->groups[k];
            const double *H = w->pieces[k].H, *V = g->V;
            const int nxe = g->elements->nxe, nee = g->elements->nee, m = g->elements->n;
            if (g->curved) for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++)
                w->force[g->x[a * m + i]] += H[(a * nxe + c) * m + i] * w->dx[g->x[c * m + i]];
            for (int r = 0; r < nee; r++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++)
                extra[g->e[r * m + i]] += V[(r * nxe + c) * m + i] * w->dx[g->x[c * m + i]];
        }
        for (int i = 0; i < q->nx; i++) if (w->place[i] >= 0) w->right[w->place[i]] -= w->force[i];
        for (int i = 0; i < q->ne; i++) w->right[nf + i] -= q->size * w->coupled[i] * extra[i];
    }
    for (int i = 0; i < n; i++) {
        const double sign = i % 2 ? -1.0 : 1.0, probe = i < nf ? q->size * (1.0 + (double)i / nf) : 0.0;
        w->z[w->rank[i]] = (quad){ w->right[i], sign * w->rounding[i], probe, 0.0 };
    }
    band_solve(w->band, n, w->b, w->pivots, w->z);
    double growth = 0.0, sum = 0.0;
    *noise = 0.0;
    for (int i = 0; i < q->nx; i++) {
        const int at = w->place[i];
        if (at < 0) continue;
        const quad z = w->z[w->rank[at]];
        growth = larger(growth, z[2]);
        *noise = larger(*noise, z[1] / q->scale[i]);
        w->dx[i] = z[0];
    }
    for (int i = 0; i < n; i++) sum += w->z[i][0];
    return growth < q->singular && *noise < q->no_digits && isfinite(sum) ? OK : ANOTHER_WAY;
}

/* Has the iteration ended at the last residual? 1 or 0, -1 when it has to be broken off. */
static int rest_met(const Equilibrium *q)
{
    if (!isfinite(q->work_force + q->gap)) return -1;
    if (!q->iterations) {
        if (q->quiet || q->forces <= q->guess_forces) return (int)q->quiet;
        return q->work <= q->guess_forces * q->work_size && q->gap <= q->guess_lengths;
    }
    const double last = q->sizes[q->iterations - 1];
    const int small = q->work <= q->forces * q->work_size && q->work_force <= q->tolerance && q->gap <= q->lengths;
    return last <= q->noise || ((q->quiet || small) && last <= q->correction);
}

static void give_point(const Equilibrium *q, const Own *w)
{
    double *out = q->out;
    memcpy(out, w->x, sizeof(double) * q->nx); out += q->nx;
    memcpy(out, w->sigma, sizeof(double) * q->ne); out += q->ne;
    memcpy(out, w->right, sizeof(double) * w->n); out += w->n;
    memcpy(out, w->rounding, sizeof(double) * w->n);
}

/* The loads, and the state to begin with: x, sigma. */
static void rest_begin(const Equilibrium *q, const Own *w)
{
    rest_loads(q, w);
    memcpy(w->x, q->x, sizeof(double) * q->nx);
    memcpy(w->sigma, q->sigma, sizeof(double) * q->ne);
    memset(w->dx, 0, sizeof(double) * q->nx);
}

/* Newton's iteration from x, sigma; what `sizes` holds of corrections tells Python why it was broken off. */
static int spacar_equilibrium_newton(Equilibrium *q)
{
    Own *w = q->own;
    int prescribed = 0;
    q->iterations = 0;
    q->noise = 0.0;
    rest_begin(q, w);
    memcpy(w->before, q->branch, sizeof(double) * q->ne);
    for (int i = (int)q->x_input; i < q->x_input + q->n_x_input; i++) {
        w->dx[i] = w->given_x[i] - w->x[i];
        if (w->dx[i] != 0.0) prescribed = 1;
    }
    double least = 1.0;
    for (int i = 0; i < q->nx; i++) least = larger(least, w->x[i] / q->scale[i]);
    least *= q->floor;
    for (;; prescribed = 0) {
        double noise, size = 0.0;
        rest_residual(q, w, w->x, w->sigma);
        const int met = prescribed ? 0 : rest_met(q);
        if (met < 0) return NOT_A_NUMBER;
        if (met) { give_point(q, w); return FOUND; }
        if (q->iterations && q->iterations >= q->limit) return NO_END;
        if (rest_factor(q, w, w->sigma) != OK || rest_correct(q, w, prescribed, &noise) != OK) {
            memcpy(q->branch, w->before, sizeof(double) * q->ne);
            return ANOTHER_WAY;
        }
        for (int i = 0; i < q->nx; i++) size = larger(size, w->dx[i] / q->scale[i]);
        q->sizes[q->iterations++] = size;
        q->noise = q->spread * (noise > least ? noise : least);
        if (!(size <= q->jump)) return TOO_LARGE;
        if (q->iterations > 1 && size > q->noise) {
            const double ratio = q->iterations == 2 ? q->first_ratio : q->later_ratio;
            if (!(size <= ratio * q->sizes[q->iterations - 2])) return GROWING;
        }
        rest_follow(q, w);
        for (int i = 0; i < q->nx; i++) w->x[i] += w->dx[i];
        for (int i = 0; i < q->ne; i++) w->sigma[i] += q->size * w->z[w->rank[q->nf + i]][0];
        memset(w->dx, 0, sizeof(double) * q->nx);
    }
}

/* The residual at x, sigma. */
static int spacar_equilibrium_point(Equilibrium *q)
{
    Own *w = q->own;
    rest_begin(q, w);
    rest_residual(q, w, w->x, w->sigma);
    give_point(q, w);
    return OK;
}

/* Sign of the determinant of the last factored matrix; 0 when it is singular. */
static double spacar_equilibrium_sign(const Equilibrium *q)
{
    const Own *w = q->own;
    return w->factored ? band_sign(w->band, w->n, w->b, w->pivots) : 0.0;
}

/* The matrix at x, sigma, factored, and the sign of its determinant. ANOTHER_WAY: it is singular. */
static int spacar_equilibrium_factor(Equilibrium *q)
{
    Own *w = q->own;
    double noise;
    rest_begin(q, w);
    rest_residual(q, w, w->x, w->sigma);
    if (rest_factor(q, w, w->sigma) != OK || rest_correct(q, w, 0, &noise) != OK) return ANOTHER_WAY;
    q->sign = band_sign(w->band, w->n, w->b, w->pivots);
    return OK;
}
