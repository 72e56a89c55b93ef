/* The linearized equations about an equilibrium: V, the transfer functions W and We, the stresses of the given deformations, the mass
   matrix, the stiffness of the elements, the geometric stiffness, the gradient of gravity, and the matrices of the degrees of freedom that
   they give. Formulas: spacar/linearization: coefficients.py, matrices.py, and spacar/kinematics: transfer.py, constraint_condition.py.
   Dense, for small models without kinematic coordinates: the given rows E of V are the first n, the unknowns U the n coordinates from
   `first` on, and the degrees of freedom follow each other in x and in e. */
/* (|D|_1 |D|_inf)^1/2 |D^-1|_F of the scaled matrix D of V[E, U] and its inverse: see constraint_condition.py. */
static double condition_bound(const Linearized *l, const double *V, int nx, const double *inverse)
{
    const int n = (int)l->n;
    double rows = 0.0, columns = 0.0, squares = 0.0;
    for (int i = 0; i < n; i++) {
        double row = 0.0, column = 0.0;
        for (int j = 0; j < n; j++) {
            row += fabs(V[i * nx + l->first + j] * l->column[j] / l->row[i]);
            column += fabs(V[j * nx + l->first + i] * l->column[i] / l->row[j]);
            const double entry = inverse[i * n + j] * l->row[j] / l->column[i];
            squares += entry * entry;
        }
        rows = larger(rows, row);
        columns = larger(columns, column);
    }
    const double bound = n ? sqrt(rows * columns) * sqrt(squares) : 1.0;
    return isfinite(bound) ? bound : INFINITY;
}

/* The mass matrices that depend on x. OK or NO_MEMORY. */
static int add_element_masses(const Equilibrium *q, const Linearized *l)
{
    for (int k = 0; k < l->n_groups; k++) {
        const Group *g = &q->groups[k];
        const int nxe = g->elements->nxe, m = g->elements->n;
        if (!g->moving) continue;
        double *x = malloc((nxe + 1) * sizeof(double) * nxe * m), *M = x + nxe * m;
        if (!x) return NO_MEMORY;
        for (int i = 0; i < nxe * m; i++) x[i] = q->x[g->x[i]];
        spacar_elements_inertia(g->elements, x, NULL, NULL, M, NULL);
        for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++, M++)
            l->mass[g->x[a * m + i] * q->nx + g->x[c * m + i]] += *M;
        free(x);
    }
    return OK;
}

/* out (m, m) += W^T A W of A (n, n), W (n, m); `row` is room for m numbers. Zeros of A and W are passed over. */
static void add_between(const double *A, const double *W, int n, int m, double *restrict row, double *restrict out)
{
    for (int r = 0; r < n; r++, A += n) {
        int any = 0;
        memset(row, 0, m * sizeof(double));
        for (int c = 0; c < n; c++) if (A[c] != 0.0) {
            any = 1;
            for (int j = 0; j < m; j++) row[j] += A[c] * W[c * m + j];
        }
        if (any) for (int i = 0; i < m; i++) {
            const double left = W[r * m + i];
            if (left != 0.0) for (int j = 0; j < m; j++) out[i * m + j] += left * row[j];
        }
    }
}

/* At x with the stresses sigma; leaves the given deformations in e as they are given. ANOTHER_WAY: singular, or the gradient of gravity is not symmetric. */
static int spacar_equilibrium_linearize(Equilibrium *q, Linearized *l)
{
    Own *w = q->own;
    const int n = (int)l->n, nx = (int)q->nx, first = (int)l->first, k = (int)l->n_q_x, ndof = k + (int)l->n_q_e;
    rest_loads(q, w);
    rest_elements(q, w, q->x);
    for (int i = 0; i < q->ne; i++) if (prescribes(q, i)) q->e[i] = w->given_e[i];
    rest_weight(q, w);
    for (int i = 0; i < nx; i++) w->force[i] = w->applied[i] - w->weight[i];
    l->guard = 1.0;
    for (int g = 0; g < q->n_groups; g++) {
        const Group *group = &q->groups[g];
        const double *V = group->V, guard = spacar_elements_guard(group->elements, w->pieces[g].x);
        const int nxe = group->elements->nxe, nee = group->elements->nee, m = group->elements->n;
        if (!(guard >= l->guard)) l->guard = guard;
        if (group->S) for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) for (int i = 0; i < m; i++) {
            const int64_t e = group->e[r * m + i], f = group->e[c * m + i];
            if (!prescribes(q, e) && !prescribes(q, f)) l->S[e * q->ne + f] += group->S[(r * nee + c) * m + i];
        }
        for (int r = 0; r < group->elements->nee; r++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++, V++) {
            const int64_t e = group->e[r * m + i], x = group->x[c * m + i];
            l->V[e * nx + x] += *V;
            if (e >= n) w->force[x] -= *V * l->sigma[e];
        }
    }
    double *room = calloc(2 * (size_t)n * n + (size_t)n * k + ndof + 1, sizeof(double)), *inverse = room + n * n, *moved = inverse + n * n;
    double *row = moved + n * k;
    int *pivots = malloc((n + 1) * sizeof(int)), status = NO_MEMORY;
    if (!room || !pivots) goto end;
    for (int i = 0; i < n; i++) {
        memcpy(room + i * n, l->V + i * nx + first, n * sizeof(double));
        inverse[i * n + i] = 1.0;
        for (int j = 0; j < k; j++) moved[i * k + j] = -l->V[i * nx + l->q_x + j];
        l->sigma[i] = w->force[first + i];
    }
    status = ANOTHER_WAY;
    if (dense_factor(room, n, pivots) != OK) goto end;
    dense_solve(room, n, pivots, inverse, n);
    dense_solve(room, n, pivots, moved, k);
    dense_solve_transposed(room, n, pivots, l->sigma);
    l->bound = condition_bound(l, l->V, nx, inverse);
    for (int i = 0; i < n; i++) { /* unit rates of the degrees of freedom, one after the other */
        double *W = l->W + (first + i) * ndof;
        memcpy(W, moved + i * k, k * sizeof(double));
        memcpy(W + k, inverse + i * n + l->q_e, (ndof - k) * sizeof(double));
    }
    for (int j = 0; j < k; j++) l->W[(l->q_x + j) * ndof + j] = 1.0;
    for (int j = k; j < ndof; j++) l->We[(l->q_e + j - k) * ndof + j] = 1.0;
    for (int r = n; r < q->ne; r++) for (int c = 0; c < nx; c++) {
        const double V = l->V[r * nx + c];
        if (V != 0.0) for (int j = 0; j < ndof; j++) l->We[r * ndof + j] += V * l->W[c * ndof + j];
    }
    if (!rest_blocks(q, w, l->sigma)) goto end;
    l->terms = 0.0;
    for (int g = 0; g < q->n_groups; g++) {
        const Group *group = &q->groups[g];
        const Piece *p = &w->pieces[g];
        const int nxe = group->elements->nxe, m = group->elements->n;
        for (int i = 0; i < m; i++) {
            double largest = 0.0;
            for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) {
                const int64_t r = group->x[a * m + i], s = group->x[c * m + i];
                const int at = (a * nxe + c) * m + i;
                if (group->curved) {
                    l->geometric[r * nx + s] += p->H[at];
                    largest = larger(largest, p->H[at] * q->scale[r] * q->scale[s]);
                }
                if (group->heavy) l->gravity[r * nx + s] += p->by_x[at];
            }
            l->terms += largest;
        }
    }
    if ((status = add_element_masses(q, l)) != OK) goto end;
    add_between(l->mass, l->W, nx, ndof, row, l->m0);
    add_between(l->S, l->We, (int)q->ne, ndof, row, l->k0);
    add_between(l->geometric, l->W, nx, ndof, row, l->g0);
    if (l->gravity) add_between(l->gravity, l->W, nx, ndof, row, l->g0);
    status = isfinite(l->bound) ? OK : ANOTHER_WAY;
end:
    free(room);
    free(pivots);
    return status;
}
