/* Equilibrium at rest: the residual of the mixed equations, Newton's iteration on them; definite.c proves that a state is stable. For one
   holonomic mechanism without user functions, moments and flow. Formulas, criteria and constants are those of
   spacar/stationary (stationary_equations.py, newton.py, tangent.py, definite.py), which gives the constants; what is unusual (a
   singular matrix, a tangent that is not symmetric) ends with ANOTHER_WAY, and Python does it all over in its own way.

   Elements have the arrays of batches.c, (..., n), one after the other in the arrays of the whole. */
enum { FOUND = 0, ANOTHER_WAY = 1, NOT_A_NUMBER = 2, TOO_LARGE = 3, GROWING = 4, NO_END = 5 }; /* as in equilibrium.py */

/* The elements of one type. */
typedef struct {
    const Elements *elements;
    const int64_t *x, *e;      /* (nxe, n), (nee, n) places */
    double *V;                 /* (nee, nxe, n) */
    const double *S, *held;    /* (nee, nee, n) active stiffness or NULL, (nee, n) constrained / size^2: for the proof */
    int64_t curved, heavy;     /* V depends on x; gravity depends on x */
} Group;

typedef struct {
    const Group *groups;
    const int64_t *v_rows, *v_columns, *place, *flexible_rows, *flexible_columns, *rigid; /* as SparseTangent, Flexibility */
    const double *flexible, *rigid_diagonal, *coupled, *loose, *passive;                  /* passive (ne): 1 or 0 */
    const double *scale, *e_scale, *least;                                                /* least size of coordinates */
    /* of the two parts of the loading, of which `parts` is taken: forces, stresses, gravity (nx), prescribed values */
    const double *force[2], *preload[2], *gravity[2], *x_start, *x_step[2], *e_step[2], *held;
    double *near, *e, *V;                                                                 /* (ne), (ne), (n_v) of the sweep */
    int64_t nx, ne, nf, n_groups, n_v, n_flexible, n_rigid, x_input, n_x_input, e_input, n_e_input, heavy, widest, dense;
    double size, parts[2], hold;
    double floor, singular, no_digits, spread, first_ratio, later_ratio, jump, symmetric, guess_forces, guess_lengths, weight, safe, elastic;
    int64_t widest_definite;
    /* what an iteration has to reach, from where, and what comes out */
    double forces, lengths, correction, tolerance;
    double *x, *sigma, *out, *sizes;                                                      /* out: x, sigma, right, rounding; (limit) */
    int64_t limit, iterations, quiet;
    double work_force, work, work_size, gap, noise, sign;
    void *own;
} Equilibrium;

typedef struct { double *x, *near, *e, *H, *by_x, *sigma; int *at, *by_x_at, *definite_at; } Piece; /* of a group */

/* What belongs to C: places in the band, and room. */
typedef struct {
    int n, b, *pivots, *v_at, *turned_at, *constant_at, *rank, factored;
    double *v_factor, *constant, *band;
    quad *z;
    Piece *pieces;
    double *applied, *given_x, *given_e, *preload, *x, *sigma, *force, *sizes, *gap, *lengths, *right, *rounding, *dx, *inertia, *weight, *still, *before;
    int definite_b, definite_known;
    double *definite_band, *definite_size;
    void *memory[64];
    int n_memory;
} Own;

static void *room_of(Own *w, size_t count, size_t size)
{
    void *memory = cleared(count ? count : 1, size);
    if (memory) w->memory[w->n_memory++] = memory;
    return memory;
}

static double larger(double m, double a) /* that is not a number when one of them is not */
{
    a = fabs(a);
    return a > m || a != a ? a : m;
}

static void spacar_equilibrium_end(Equilibrium *q)
{
    Own *w = q->own;
    if (!w) return;
    for (int k = 0; k < w->n_memory; k++) free(w->memory[k]);
    free(w);
    q->own = NULL;
}

/* Places of the coordinates of square blocks (nxe, nxe, n) among the free ones: pairs, from *count on. */
static void pairs_of(const Equilibrium *q, const Group *g, int *rows, int *columns, int *count)
{
    const int nxe = g->elements->nxe, n = g->elements->n;
    for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < n; i++, (*count)++) {
        rows[*count] = (int)q->place[g->x[a * n + i]];
        columns[*count] = (int)q->place[g->x[c * n + i]];
    }
}

static int where(const int *rank, int b, int row, int column) /* in the band; -1 for what is left out */
{
    return row < 0 || column < 0 ? -1 : rank[column] * (3 * b + 1) + 2 * b + rank[row] - rank[column];
}

/* The patterns. OK, NO_MEMORY, or ANOTHER_WAY when the band is wide. */
static int spacar_equilibrium_begin(Equilibrium *q)
{
    Own *w = q->own = calloc(1, sizeof *w);
    if (!w) return NO_MEMORY;
    const int nf = (int)q->nf, n = w->n = nf + (int)q->ne, nc = (int)(q->n_flexible + q->n_rigid);
    size_t xs = 0, es = 0, squares = 0;
    for (int k = 0; k < q->n_groups; k++) {
        const Elements *t = q->groups[k].elements;
        xs += (size_t)t->nxe * t->n; es += (size_t)t->nee * t->n; squares += (size_t)t->nxe * t->nxe * t->n;
    }
    const size_t sum = 2 * squares + 2 * q->n_v + nc, numbers = 2 * xs + 3 * es + 3 * squares + 8 * (size_t)q->nx + 6 * (size_t)q->ne + 2 * (size_t)n;
    int *rows = room_of(w, sum, sizeof(int)), *columns = room_of(w, sum, sizeof(int));
    int *places = room_of(w, 3 * squares, sizeof(int));
    w->pieces = room_of(w, q->n_groups, sizeof(Piece));
    w->rank = room_of(w, n, sizeof(int));
    w->pivots = room_of(w, n, sizeof(int));
    w->v_at = room_of(w, q->n_v, sizeof(int));
    w->turned_at = room_of(w, q->n_v, sizeof(int));
    w->v_factor = room_of(w, q->n_v, sizeof(double));
    w->constant_at = room_of(w, nc, sizeof(int));
    w->constant = room_of(w, nc, sizeof(double));
    w->z = room_of(w, n, sizeof(quad));
    double *d = room_of(w, numbers, sizeof(double));
    if (!rows || !columns || !places || !w->pieces || !w->rank || !w->pivots || !w->v_at || !w->turned_at || !w->v_factor
        || !w->constant_at || !w->constant || !w->z || !d) return NO_MEMORY;
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const size_t e = (size_t)g->elements->nee * g->elements->n, x = (size_t)g->elements->nxe * g->elements->n, s = x * g->elements->nxe;
        Piece *p = &w->pieces[k];
        p->x = d; p->near = d + x; p->e = p->near + e; p->sigma = p->e + e; d = p->sigma + e;
        p->H = d; p->by_x = d + s; d += 3 * s;
        p->at = places; p->by_x_at = places + s; p->definite_at = places + 2 * s; places += 3 * s;
    }
    double **vectors[] = { &w->applied, &w->given_x, &w->force, &w->sizes, &w->x, &w->dx, &w->inertia, &w->weight };
    for (int k = 0; k < 8; k++, d += q->nx) *vectors[k] = d;
    double **stresses[] = { &w->given_e, &w->preload, &w->sigma, &w->gap, &w->lengths, &w->before };
    for (int k = 0; k < 6; k++, d += q->ne) *stresses[k] = d;
    w->right = d; w->rounding = d + n; w->still = d + 2 * n;
    int count = 0;
    for (int k = 0; k < q->n_groups; k++) {
        if (q->groups[k].curved) pairs_of(q, &q->groups[k], rows, columns, &count);
        if (q->groups[k].heavy) pairs_of(q, &q->groups[k], rows, columns, &count);
    }
    const int first_v = count;
    for (int k = 0; k < q->n_v; k++, count++) { rows[count] = nf + (int)q->v_rows[k]; columns[count] = (int)q->place[q->v_columns[k]]; }
    const int first_c = count;
    for (int k = 0; k < q->n_flexible; k++, count++) {
        rows[count] = nf + (int)q->flexible_rows[k];
        columns[count] = nf + (int)q->flexible_columns[k];
        w->constant[k] = -q->size * q->flexible[k];
    }
    for (int k = 0; k < q->n_rigid; k++, count++) {
        rows[count] = columns[count] = nf + (int)q->rigid[k];
        w->constant[q->n_flexible + k] = -q->size * q->rigid_diagonal[k];
    }
    Graph graph = {0};
    int status = graph_of(&graph, n, rows, columns, count);
    if (status == OK) status = band_order(&graph, w->rank);
    if (status == OK) {
        w->b = band_width(&graph, w->rank);
        if (3 * w->b + 1 >= q->widest && n > q->dense) status = ANOTHER_WAY;
    }
    free_graph(&graph);
    if (status != OK) return status;
    w->band = room_of(w, (size_t)n * (3 * w->b + 1), sizeof(double));
    if (!w->band) return NO_MEMORY;
    count = 0;
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const int s = g->elements->nxe * g->elements->nxe * g->elements->n;
        if (g->curved) for (int i = 0; i < s; i++, count++) w->pieces[k].at[i] = where(w->rank, w->b, rows[count], columns[count]);
        if (g->heavy) for (int i = 0; i < s; i++, count++) w->pieces[k].by_x_at[i] = where(w->rank, w->b, rows[count], columns[count]);
    }
    for (int k = 0; k < q->n_v; k++) {
        w->v_at[k] = where(w->rank, w->b, rows[first_v + k], columns[first_v + k]);
        w->turned_at[k] = where(w->rank, w->b, columns[first_v + k], rows[first_v + k]);
        w->v_factor[k] = q->size * q->coupled[q->v_rows[k]];
    }
    for (int k = 0; k < nc; k++) w->constant_at[k] = where(w->rank, w->b, rows[first_c + k], columns[first_c + k]);
    return OK;
}

/* The loads and the prescribed values of the parts. */
static void rest_loads(const Equilibrium *q, const Own *w)
{
    const double a = q->parts[0], b = q->parts[1];
    for (int i = 0; i < q->nx; i++) w->applied[i] = a * q->force[0][i] + b * q->force[1][i];
    for (int i = 0; i < q->ne; i++) w->preload[i] = a * q->preload[0][i] + b * q->preload[1][i];
    if (q->heavy) for (int i = 0; i < q->nx; i++) w->inertia[i] = -(a * q->gravity[0][i] + b * q->gravity[1][i]);
    for (int i = 0; i < q->n_x_input; i++) w->given_x[q->x_input + i] = q->x_start[i] + a * q->x_step[0][i] + b * q->x_step[1][i];
    for (int i = 0; i < q->n_e_input; i++) w->given_e[q->e_input + i] = a * q->e_step[0][i] + b * q->e_step[1][i];
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
        for (int i = 0; i < ne; i++) p->near[i] = q->near[g->e[i]];
        spacar_elements_strain(g->elements, p->x, p->near, p->e, g->V);
        for (int i = 0; i < ne; i++) q->e[g->e[i]] = p->e[i];
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
    const double *V = q->V;
    rest_elements(q, w, x);
    for (int i = 0; i < nx; i++) { w->force[i] = w->applied[i]; w->sizes[i] = fabs(w->applied[i]); }
    for (int i = 0; i < ne; i++) {
        if (q->passive && q->passive[i] != 0.0) sigma[i] = w->preload[i];
        w->lengths[i] = 0.0;
        w->gap[i] = q->coupled[i] * (q->e[i] - w->given_e[i]);
    }
    for (int k = 0; k < q->n_v; k++) {
        const int r = (int)q->v_rows[k], c = (int)q->v_columns[k];
        const double part = V[k] * sigma[r], size = fabs(x[c]);
        w->force[c] -= part;
        w->sizes[c] += fabs(part);
        w->lengths[r] += fabs(V[k]) * (size > q->least[c] ? size : q->least[c]);
    }
    if (q->heavy) {
        rest_weight(q, w);
        for (int i = 0; i < nx; i++) { w->force[i] -= w->weight[i]; w->sizes[i] += fabs(w->weight[i]); }
    }
    if (q->held) for (int i = 0; i < nx; i++) w->force[i] -= q->hold * q->held[i];
    for (int k = 0; k < q->n_flexible; k++) {
        const int r = (int)q->flexible_rows[k], c = (int)q->flexible_columns[k];
        w->gap[r] -= q->flexible[k] * ((sigma[c] - w->preload[c]) * q->loose[c]) / q->size;
    }
    for (int k = 0; k < q->n_rigid; k++) {
        const int r = (int)q->rigid[k];
        w->gap[r] -= q->rigid_diagonal[k] * ((sigma[r] - w->preload[r]) * q->loose[r]) / q->size;
    }
    q->work_force = q->work = q->work_size = q->gap = 0.0;
    q->quiet = 1;
    for (int i = 0; i < nx; i++) {
        q->work_size = larger(q->work_size, w->applied[i] * q->scale[i]);
        const int at = (int)q->place[i];
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
        w->rounding[nf + i] = q->coupled[i] != 0.0 ? w->lengths[i] * q->floor * q->size : 0.0;
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

static int rest_factor(const Equilibrium *q, Own *w, const double *sigma)
{
    const double *V = q->V;
    if (!rest_blocks(q, w, sigma)) return ANOTHER_WAY;
    memset(w->band, 0, sizeof(double) * w->n * (3 * (size_t)w->b + 1));
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        const int s = g->elements->nxe * g->elements->nxe * g->elements->n;
        if (g->curved) for (int i = 0; i < s; i++) if (p->at[i] >= 0) w->band[p->at[i]] += p->H[i];
        if (g->heavy) for (int i = 0; i < s; i++) if (p->by_x_at[i] >= 0) w->band[p->by_x_at[i]] += p->by_x[i];
    }
    for (int k = 0; k < q->n_v; k++) {
        if (w->v_at[k] < 0) continue;
        const double value = w->v_factor[k] * V[k];
        w->band[w->v_at[k]] += value;
        w->band[w->turned_at[k]] += value;
    }
    const int nc = (int)(q->n_flexible + q->n_rigid);
    for (int k = 0; k < nc; k++) w->band[w->constant_at[k]] += w->constant[k];
    w->factored = band_factor(w->band, w->n, w->b, w->pivots) == OK;
    return w->factored ? OK : ANOTHER_WAY;
}

/* Correction of the last residual, in dx and z, where dx holds the changes of prescribed coordinates. ANOTHER_WAY: singular. */
static int rest_correct(Equilibrium *q, Own *w, int prescribed, double *noise)
{
    const int n = w->n, nf = (int)q->nf;
    double *extra = w->lengths; /* not needed any more */
    if (prescribed) { /* the matrix times dx */
        memset(w->force, 0, sizeof(double) * q->nx);
        memset(extra, 0, sizeof(double) * q->ne);
        for (int k = 0; k < q->n_groups; k++) {
            const Group *g = &q->groups[k];
            const int nxe = g->elements->nxe, m = g->elements->n;
            if (!g->curved) continue;
            for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++)
                w->force[g->x[a * m + i]] += w->pieces[k].H[(a * nxe + c) * m + i] * w->dx[g->x[c * m + i]];
        }
        const double *V = q->V;
        for (int k = 0; k < q->n_v; k++) extra[q->v_rows[k]] += V[k] * w->dx[q->v_columns[k]];
        for (int i = 0; i < q->nx; i++) if (q->place[i] >= 0) w->right[q->place[i]] -= w->force[i];
        for (int i = 0; i < q->ne; i++) w->right[nf + i] -= q->size * q->coupled[i] * extra[i];
    }
    for (int i = 0; i < n; i++) {
        const double sign = i % 2 ? -1.0 : 1.0, probe = i < nf ? q->size * (1.0 + (double)i / nf) : 0.0;
        w->z[w->rank[i]] = (quad){ w->right[i], sign * w->rounding[i], probe, 0.0 };
    }
    band_solve(w->band, n, w->b, w->pivots, w->z);
    double growth = 0.0, sum = 0.0;
    *noise = 0.0;
    for (int i = 0; i < q->nx; i++) {
        const int at = (int)q->place[i];
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

/* Newton's iteration from x, sigma; what `sizes` holds of corrections tells Python why it was broken off. */
static int spacar_equilibrium_newton(Equilibrium *q)
{
    Own *w = q->own;
    int prescribed = 0;
    q->iterations = 0;
    q->noise = 0.0;
    rest_loads(q, w);
    memcpy(w->x, q->x, sizeof(double) * q->nx);
    memcpy(w->sigma, q->sigma, sizeof(double) * q->ne);
    memcpy(w->before, q->near, sizeof(double) * q->ne);
    memset(w->dx, 0, sizeof(double) * q->nx);
    for (int i = (int)q->x_input; i < q->x_input + q->n_x_input; i++) {
        w->dx[i] = w->given_x[i] - w->x[i];
        if (w->dx[i] != 0.0) prescribed = 1;
    }
    rest_residual(q, w, w->x, w->sigma);
    if (!prescribed) {
        const int met = rest_met(q);
        if (met < 0) return NOT_A_NUMBER;
        if (met) { give_point(q, w); return FOUND; }
    }
    double least = 1.0;
    for (int i = 0; i < q->nx; i++) least = larger(least, w->x[i] / q->scale[i]);
    least *= q->floor;
    for (;;) {
        double noise, size = 0.0;
        if (rest_factor(q, w, w->sigma) != OK || rest_correct(q, w, prescribed, &noise) != OK) {
            memcpy(q->near, w->before, sizeof(double) * q->ne);
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
        memcpy(q->near, q->e, sizeof(double) * q->ne);
        for (int i = 0; i < q->nx; i++) w->x[i] += w->dx[i];
        for (int i = 0; i < q->ne; i++) w->sigma[i] += q->size * w->z[w->rank[q->nf + i]][0];
        rest_residual(q, w, w->x, w->sigma);
        const int met = rest_met(q);
        if (met < 0) return NOT_A_NUMBER;
        if (met) { give_point(q, w); return FOUND; }
        if (q->iterations >= q->limit) return NO_END;
        memset(w->dx, 0, sizeof(double) * q->nx);
        prescribed = 0;
    }
}

/* The residual at x, sigma. */
static int spacar_equilibrium_point(Equilibrium *q)
{
    Own *w = q->own;
    rest_loads(q, w);
    memcpy(w->x, q->x, sizeof(double) * q->nx);
    memcpy(w->sigma, q->sigma, sizeof(double) * q->ne);
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
    rest_loads(q, w);
    memcpy(w->x, q->x, sizeof(double) * q->nx);
    memcpy(w->sigma, q->sigma, sizeof(double) * q->ne);
    memset(w->dx, 0, sizeof(double) * q->nx);
    rest_residual(q, w, w->x, w->sigma);
    if (rest_factor(q, w, w->sigma) != OK || rest_correct(q, w, 0, &noise) != OK) return ANOTHER_WAY;
    q->sign = band_sign(w->band, w->n, w->b, w->pivots);
    return OK;
}
