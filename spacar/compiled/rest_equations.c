/* The mixed equations at rest: loads, elements, residual, and the blocks of the tangent. Formulas:
   spacar/stationary/stationary_equations.py, tangent.py. */

/* The loads and the prescribed values of the parts. */
static void rest_loads(const Equilibrium *q, const Own *w)
{
    const double a = q->parts[0], b = q->parts[1], *one = q->loads,
        *other = one + 2 * q->nx + q->ne + q->n_x_input + q->n_e_input;
    for (int i = 0; i < q->nx; i++) w->applied[i] = a * *one++ + b * *other++;
    for (int i = 0; i < q->nx; i++) w->inertia[i] = -(a * *one++ + b * *other++);
    for (int i = 0; i < q->ne; i++, one++, other++) w->preload[i] = prescribes(q, i) ? 0.0 : a * *one + b * *other;
    for (int64_t i = q->x_input; i < q->x_input + q->n_x_input; i++)
        w->given_x[i] = q->x0[i] + a * *one++ + b * *other++;
    for (int64_t i = q->e_input; i < q->e_input + q->n_e_input; i++) w->given_e[i] = a * *one++ + b * *other++;
}

/* The elements at x: e, V. */
static void rest_elements(const Equilibrium *q, const Own *w, const double *x)
{
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        const int nx = g->elements->nxe * g->elements->n, ne = g->elements->nee * g->elements->n;
        for (int i = 0; i < nx; i++) p->x[i] = x[g->x[i]];
        if (!ne) continue;
        for (int i = 0; i < ne; i++) p->branch[i] = q->branch[g->e[i]];
        spacar_elements_strain(g->elements, p->x, p->branch, p->e, g->V);
        for (int i = 0; i < ne; i++) q->e[g->e[i]] = p->e[i];
    }
}

/* The next state is on the branch of the one where the elements were evaluated last. */
static void rest_follow(const Equilibrium *q, const Own *w)
{
    memcpy(q->branch, q->e, sizeof(double) * q->ne);
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        if (!g->elements->nee || !ANGLE[g->elements->kind]) continue;
        spacar_elements_angle(g->elements, p->x, p->e, p->branch);
        for (int i = 0; i < g->elements->n; i++) q->branch[g->e[i]] = p->branch[i];
    }
}

/* Minus the gravity of the elements whose gravity depends on x, at the last evaluated elements. */
static void rest_weight(const Equilibrium *q, const Own *w)
{
    memset(w->weight, 0, sizeof(double) * q->nx);
    for (int k = 0; q->heavy && k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        const int count = g->elements->nxe * g->elements->n;
        if (!g->heavy) continue;
        for (int i = 0; i < count; i++) p->H[i] = w->inertia[g->x[i]];
        spacar_elements_inertia(g->elements, p->x, NULL, p->H, NULL, p->by_x);
        for (int i = 0; i < count; i++) w->weight[g->x[i]] += p->by_x[i];
    }
}

/* The residual at x, sigma, with what the criteria need, into `right`, `rounding`. */
static void rest_residual(Equilibrium *q, const Own *w, const double *x, double *sigma)
{
    const int nx = (int)q->nx, ne = (int)q->ne, nf = (int)q->nf;
    rest_elements(q, w, x);
    for (int i = 0; i < nx; i++) { w->force[i] = w->applied[i]; w->sizes[i] = fabs(w->applied[i]); }
    for (int i = 0; i < ne; i++) {
        if (w->coupled[i] == 0.0) sigma[i] = w->preload[i];
        w->lengths[i] = 0.0;
        w->gap[i] = w->coupled[i] * (q->e[i] - w->given_e[i]) - (q->held ? q->hold * q->held[nx + i] : 0.0);
    }
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const double *C = w->pieces[k].C, *V = g->V;
        const int nxe = g->elements->nxe, nee = g->elements->nee, n = g->elements->n;
        for (int r = 0; r < nee; r++) for (int c = 0; c < nxe; c++) for (int i = 0; i < n; i++, V++) {
            const int64_t e = g->e[r * n + i], at = g->x[c * n + i];
            const double part = *V * sigma[e], size = fabs(x[at]);
            w->force[at] -= part;
            w->sizes[at] += fabs(part);
            w->lengths[e] += fabs(*V) * (size > q->least[at] ? size : q->least[at]);
        }
        for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) for (int i = 0; i < n; i++, C++) {
            const int64_t e = g->e[c * n + i];
            if (!prescribes(q, e)) w->gap[g->e[r * n + i]] -= *C * (sigma[e] - w->preload[e]) / q->size;
        }
    }
    if (q->heavy) {
        rest_weight(q, w);
        for (int i = 0; i < nx; i++) { w->force[i] -= w->weight[i]; w->sizes[i] += fabs(w->weight[i]); }
    }
    if (q->held) for (int i = 0; i < nx; i++) w->force[i] -= q->hold * q->held[i];
    q->work_force = q->work = q->work_size = q->gap = 0.0;
    q->quiet = 1;
    for (int i = 0; i < nx; i++) {
        q->work_size = larger(q->work_size, w->applied[i] * q->scale[i]);
        const int at = w->place[i];
        if (at < 0) continue;
        w->right[at] = w->force[i];
        w->rounding[at] = w->sizes[i] * q->floor;
        q->work_force = larger(q->work_force, w->force[i]);
        q->work = larger(q->work, w->force[i] * q->scale[i]);
        if (!(fabs(w->right[at]) <= w->rounding[at])) q->quiet = 0;
    }
    for (int i = 0; i < ne; i++) {
        const double right = -q->size * w->gap[i];
        w->right[nf + i] = right;
        w->rounding[nf + i] = w->coupled[i] != 0.0 ? w->lengths[i] * q->floor * q->size : 0.0;
        q->work_size = larger(q->work_size, sigma[i] * q->e_scale[i]);
        q->gap = larger(q->gap, right / (q->size * q->e_scale[i]));
        if (!(fabs(right) <= w->rounding[nf + i])) q->quiet = 0;
    }
}

/* The blocks of the tangent at the last residual. 0 when the gradient of gravity is not symmetric. */
static int rest_blocks(const Equilibrium *q, const Own *w, const double *sigma)
{
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Elements *t = g->elements;
        const Piece *p = &w->pieces[k];
        const int nxe = t->nxe, n = t->n, s = nxe * nxe * n;
        if (g->heavy) { /* the accelerations stand in H, what changes with rates is written behind */
            for (int i = 0; i < nxe * n; i++) p->H[i] = w->inertia[g->x[i]];
            spacar_elements_inertia_gradient(t, p->x, w->still, p->H, p->by_x, p->by_x + s);
            double most = 0.0, off = 0.0;
            for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < n; i++) {
                const double value = p->by_x[(a * nxe + c) * n + i];
                most = larger(most, value);
                off = larger(off, value - p->by_x[(c * nxe + a) * n + i]);
            }
            if (!(off <= q->symmetric * most)) return 0;
        }
        if (!g->curved) continue;
        for (int i = 0; i < t->nee * n; i++) p->sigma[i] = sigma[g->e[i]];
        spacar_elements_geometric(t, p->x, p->sigma, p->H);
    }
    return 1;
}
