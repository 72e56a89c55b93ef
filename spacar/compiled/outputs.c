/* Everything of a state: what its derivatives need, and stresses, rates of all deformations and nodal forces, as
   frames have them.

   Of a rigid tree they come without equations, stresses from the tips inwards (theory-system.md section 13). */

/* Elements and constant masses: `total` += M a, `gravity` += M g. */
static void weigh_elements(const Model *m, const real *a, const real *g, real *total, real *gravity)
{
    int element = 0;
    for (int b = 0; b < m->s.n_batches; element += m->s.batches[b++].n) {
        const Batch *k = &m->s.batches[b];
        const int nxe = k->nxe;
        if (!k->inertia) continue;
        for (int i = 0; i < k->n && k->foreign; i++) {
            const real *M = m->values + m->m_offset[element] + i;
            for (int r = 0; r < nxe; r++)
                for (int c = 0; c < nxe; c++, M += k->n) {
                    total[k->x[i * nxe + r]] += *M * a[k->x[i * nxe + c]];
                    gravity[k->x[i * nxe + r]] += *M * g[k->x[i * nxe + c]];
                }
        }
        for (int i = 0; i < k->n && !k->foreign; i++) {
            const int *x = k->x + i * nxe;
            const real *row = m->values + m->m_offset[element + i];
            real of_a[MAX_X] = {0}, of_g[MAX_X] = {0};
            for (int c = 0; c < nxe; c++, row += nxe) { /* a row of M is a column of it */
                const real factor = a[x[c]], field = g[x[c]];
                for (int r = 0; r < nxe; r++) of_a[r] += factor * row[r];
                int pulls = 0;
                EACH_LANE pulls |= LANE(field, w) != 0.0;
                if (pulls) for (int r = 0; r < nxe; r++) of_g[r] += field * row[r];
            }
            for (int r = 0; r < nxe; r++) { total[x[r]] += of_a[r]; gravity[x[r]] += of_g[r]; }
        }
    }
    for (int k = m->mass.n - m->s.n_constant; k < m->mass.n; k++) {
        const real value = m->values[m->mass.source[k]];
        const int i = m->mass.row[k], j = m->mass.column[k];
        total[i] += value * a[j];
        gravity[i] += value * g[j];
    }
}

/* Applied forces, gravity M g, and M xdd + h. */
static void weigh_state(const Model *m, State *at)
{
    const Spec *s = &m->s;
    memcpy(at->applied, m->applied, sizeof(real) * s->nx);
    memset(at->gravity, 0, sizeof(real) * s->nx);
    memcpy(at->total, m->convected, sizeof(real) * s->nx);
    weigh_elements(m, at->xdd, s->field, at->total, at->gravity);
}

/* The rates of all deformations, forces M xdd + h + V^T sigma in all, applied forces, gravity M g. */
static void complete(Model *m, State *at)
{
    const Spec *s = &m->s;
    real *total = at->total;
    for (int r = 0; r < s->ne; r++) {
        at->ed[r] = rate(m, r, at->xd);
        at->edd[r] = rate(m, r, at->xdd) + m->h[r];
    }
    weigh_state(m, at);
    for (int k = 0; k < m->coupling.n; k++)
        total[m->coupling.row[k]] += m->values[m->coupling.source[k]] * at->xdd[m->coupling.column[k]];
    for (int r = 0; r < s->ne; r++) subtract_transposed(m, r, -at->sigma[r], total);
}

/* Whether the deformations of all elements at next_x are those of the tree: a residual as small as the iteration of
   positions leaves. */
static int is_placed(const Model *m, const State *at)
{
    const Spec *s = &m->s;
    const real zero = EVERY(0.0), allowed = s->criteria->converged + rounding(m, m->next_x, at->given_e);
    real sum = zero;
    for (int r = 0; r < s->ne; r++) {
        const real difference = m->next_e[r] - at->given_e[r];
        if (!(largest_lane(lanes_larger(zero, difference) - allowed * s->e_scale[r]) <= 0.0)) return 0;
        sum += difference;
    }
    return isfinite(largest_lane(sum));
}

/* What an element adds to the force at its outer end, (n) of the link: in the axes of the frame, force and moment. */
static void outer_load(const struct Tree *T, const Link *link, const real *x, const real *force, real *load)
{
    const int d = T->dimension;
    const real *R = T->attitude + (d == 2 ? 2 : 9) * link->frame;
    int n = 0;
    if (link->point >= 0) {
        const int *c = T->points[link->point].c;
        const real f[3] = {force[c[0]], force[c[1]], d == 3 ? force[c[2]] : EVERY(0.0)};
        if (d == 2) { load[n++] = R[0] * f[0] + R[1] * f[1]; load[n++] = R[0] * f[1] - R[1] * f[0]; }
        else for (int k = 0; k < 3; k++) load[n++] = R[k] * f[0] + R[3 + k] * f[1] + R[6 + k] * f[2];
    }
    if (link->node < 0) return;
    const int *c = T->orientations[link->node].c;
    real moment[3] = {force[c[0]]};
    if (d == 2) { load[n] = moment[0]; return; }
    moment_of(x, force, c, moment);
    for (int k = 0; k < 3; k++) load[n++] = R[k] * moment[0] + R[3 + k] * moment[1] + R[6 + k] * moment[2];
}

/* sigma += V^T of an element, with the stresses of its deformations. */
static void add_stresses(const Model *m, const Part *part, int element, const real *sigma, real *total)
{
    const Batch *k = part->batch;
    const int nxe = k->nxe, *x = k->x + part->i * nxe, *e = k->e + part->i * k->nee;
    const real *row = m->values + m->v_offset[element];
    real sum[MAX_X] = {0};
    for (int r = 0; r < k->nee; r++, row += nxe) {
        const real factor = sigma[e[r]];
        for (int c = 0; c < nxe; c++) sum[c] += factor * row[c];
    }
    for (int c = 0; c < nxe; c++) total[x[c]] += sum[c];
}

/* Stresses of a tree, inwards: those of an element balance what is left over at its outer end, where the elements
   that it carries have been added to `total`. Then those of normalizations, of what is left over along the Euler
   parameters. */
static void tree_stresses(const Model *m, State *at)
{
    const Spec *s = &m->s;
    const struct Tree *T = m->tree;
    real *total = at->total, load[MOST_LINKED];
    for (int i = 0; i < s->nx; i++) total[i] -= at->applied[i] + at->gravity[i];
    for (int l = T->n_links - 1; l >= 0; l--) {
        const Link *link = &T->links[l];
        const Part *part = &T->parts[link->part];
        const int n = link->n, *e = part->batch->e + part->i * n;
        real sigma[MOST_LINKED];
        outer_load(T, link, at->x, total, load);
        for (int r = n - 1; r >= 0; r--) { /* (L Q)^T sigma = -load */
            real sum = EVERY(0.0);
            for (int c = 0; c < n; c++) sum -= link->Q[r][c] * load[c];
            for (int k = r + 1; k < n; k++) sum -= link->L[k][r] * sigma[k];
            sigma[r] = sum * link->inverse[r];
        }
        for (int r = 0; r < n; r++) if (e[r] < s->n_rows) at->sigma[e[r]] = sigma[r];
        add_stresses(m, part, link->part, at->sigma, total);
    }
    for (int p = 0; p < T->n_parts; p++) {
        const Part *part = &T->parts[p];
        if (part->batch->kind != NORMALIZATION) continue;
        const int *x = part->batch->x + part->i * 4, row = part->batch->e[part->i];
        const real *v = m->values + m->v_offset[p];
        real along = EVERY(0.0), square = EVERY(0.0);
        for (int c = 0; c < 4; c++) { along += v[c] * total[x[c]]; square += v[c] * v[c]; }
        at->sigma[row] = -along / square;
        add_stresses(m, part, p, at->sigma, total);
    }
    for (int i = 0; i < s->nx; i++) total[i] += at->applied[i] + at->gravity[i];
}

/* Everything of y at t of a tree. OK or a negative reason: the equations of all elements may do better. */
static int evaluate_tree(Model *m, State *at, double t, const real *y)
{
    const Spec *s = &m->s;
    const int a = s->n_x_dynamic, b = s->n_e_dynamic;
    real *rates = m->piece;
    const int status = tree_rates(m, at, t, y, rates);
    if (status) return status;
    memcpy(m->branch, at->given_e, sizeof(real) * s->ne);
    if (catch_up_matrices(m)) return NOT_ANSWERED;
    if (!is_placed(m, at)) return NO_CONVERGENCE;
    memcpy(at->ed, m->given_ed, sizeof(real) * s->ne);
    memcpy(at->edd, m->given_edd, sizeof(real) * s->ne);
    memcpy(at->edd + s->e_dynamic, rates + 2 * a + b, sizeof(real) * b);
    weigh_state(m, at);
    tree_stresses(m, at);
    return OK;
}

/* Evaluate everything of y at t. OK or a negative reason; what has been evaluated last is there. */
static int spacar_evaluate(Model *m, State *at, double t, const real *y, double converged, double jump)
{
    if (is_evaluated(m, at, t, y)) return OK;
    int status = m->tree ? evaluate_tree(m, at, t, y) : NO_CONVERGENCE;
    if (status && status != NOT_ANSWERED) {
        status = evaluate_in_pieces(m, at, t, y, converged, jump, 1);
        if (status >= 0) complete(m, at);
    }
    if (status < 0) return status;
    memcpy(at->y, y, sizeof(real) * n_of_state(&m->s));
    at->whole = m->evaluations;
    return status;
}

/* Numbers behind the model have changed (loads, motions): what has been evaluated is not there any more. */
static void spacar_forget(Model *m) { m->evaluations++; }
