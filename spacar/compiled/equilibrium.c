/* Equilibrium at rest: the structures of the mixed equations with all coordinates and all stresses as unknowns, and
   where their parts are in a band matrix. For one holonomic mechanism without user functions, moments and flow.
   Formulas, criteria and constants are those of spacar/stationary (stationary_equations.py, flexibility.py,
   newton.py, tangent.py, definite.py); what is unusual (a singular matrix, a tangent that is not symmetric) ends with
   ANOTHER_WAY, and Python does it all over in its own way.

   Elements have the arrays of batches.c, (..., n), one after the other in the arrays of the whole. */

/* Of a group: room for its elements, the flexibility (nee, nee, n) times `size`; places in the band of the geometric
   stiffness and the gradient of gravity, of V and its transpose, of the flexibility, -1 for what is left out; places
   in the matrix of the proof. */
typedef struct {
    double *x, *branch, *e, *H, *by_x, *sigma, *C;
    int *at, *v_at, *turned_at, *c_at, *definite_row, *definite_column;
    int square, v, c; /* how many entries these have */
} Piece;

/* What belongs to C. */
typedef struct {
    int n, b, *pivots, *place, *rank, factored; /* place (nx): among the unknowns, -1 */
    double *coupled, *band;                     /* coupled (ne): 1 for rows that contain e, else 0 */
    quad *z;
    Piece *pieces;
    double *applied, *given_x, *given_e, *preload, *x, *sigma, *force, *sizes, *gap, *lengths, *right, *rounding, *dx,
        *inertia, *weight, *still, *before;
    int definite_b, definite_known;
    double elastic, *definite_band, *definite_size;
    Memory memory;
} Own;

static double larger(double m, double a) /* that is not a number when one of them is not */
{
    a = fabs(a);
    return a > m || a != a ? a : m;
}

static int prescribes(const Equilibrium *q, int64_t e) { return e < q->e_input + q->n_e_input; }

static void spacar_equilibrium_end(Equilibrium *q)
{
    Own *w = q->own;
    if (!w) return;
    give_back(&w->memory);
    free(w);
    q->own = NULL;
}

/* The flexibility of every element, `coupled`, `size`, as flexibility.py. ANOTHER_WAY where less than six of its
   binary digits are left (more than 2^-6 of the inverse may be rounding): flexibility.py decides what is singular. */
static int flexibility_of(Equilibrium *q, Own *w)
{
    double size = 0.0, longest = 0.0;
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const int nee = g->elements->nee, n = g->elements->n;
        if (!g->S) continue;
        for (int r = 0; r < nee; r++) for (int i = 0; i < n; i++) {
            const int64_t e = g->e[r * n + i];
            w->coupled[e] = !prescribes(q, e) && g->S[(r * nee + r) * n + i] != 0.0;
        }
        for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) for (int i = 0; i < n; i++)
            if (w->coupled[g->e[r * n + i]] != 0.0 && w->coupled[g->e[c * n + i]] != 0.0)
                size = larger(size, g->S[(r * nee + c) * n + i]);
    }
    if (!isfinite(size)) return ANOTHER_WAY;
    q->size = size > 0.0 ? size : 1.0;
    for (int i = 0; i < q->ne; i++) longest = larger(longest, q->e_scale[i]);
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const int nee = g->elements->nee, n = g->elements->n;
        const int b = nee - 1, height = 3 * b + 1; /* S as a band matrix that is full */
        double *C = w->pieces[k].C, S[MAX_E * 3 * MAX_E], diagonal[MAX_E];
        quad inverse[MAX_E]; /* four of its columns */
        int pivots[MAX_E];
        if (g->S) w->elastic = q->size * longest * longest;
        for (int i = 0; i < n; i++) {
            memset(S, 0, sizeof S);
            for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) {
                const int both = w->coupled[g->e[r * n + i]] != 0.0 && w->coupled[g->e[c * n + i]] != 0.0;
                const double value = both ? g->S[(r * nee + c) * n + i] / q->size : r == c;
                S[c * height + 2 * b + r - c] = value;
                if (r == c) diagonal[r] = value;
            }
            if (band_factor(S, nee, b, pivots) != OK) return ANOTHER_WAY;
            for (int c = 0; c < nee; c++) {
                if (c % 4 == 0) {
                    for (int r = 0; r < nee; r++) inverse[r] = (quad){ r == c, r == c + 1, r == c + 2, r == c + 3 };
                    band_solve(S, nee, b, pivots, inverse);
                }
                for (int r = 0; r < nee; r++) C[(r * nee + c) * n + i] = inverse[r][c % 4];
                double *own = &C[(c * nee + c) * n + i];
                if (!(fabs(*own * diagonal[c]) * DBL_EPSILON < 1.0 / 64.0)) return ANOTHER_WAY;
                *own -= prescribes(q, g->e[c * n + i]);
            }
        }
    }
    for (int i = 0; i < q->ne; i++) if (prescribes(q, i)) w->coupled[i] = 1.0;
    return OK;
}

/* Pairs of unknowns of the square blocks (nxe, nxe, n) of a group, from *count on. */
static void pairs_of(const Own *w, const Group *g, int *rows, int *columns, int *count)
{
    const int nxe = g->elements->nxe, n = g->elements->n;
    for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < n; i++, (*count)++) {
        rows[*count] = w->place[g->x[a * n + i]];
        columns[*count] = w->place[g->x[c * n + i]];
    }
}

/* The same of V and of the flexibility. */
static void pairs_of_deformations(const Own *w, const Group *g, int nf, int *rows, int *columns, int *count)
{
    const int nxe = g->elements->nxe, nee = g->elements->nee, n = g->elements->n;
    for (int r = 0; r < nee; r++) for (int c = 0; c < nxe; c++) for (int i = 0; i < n; i++, (*count)++) {
        rows[*count] = nf + (int)g->e[r * n + i];
        columns[*count] = w->place[g->x[c * n + i]];
    }
    for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) for (int i = 0; i < n; i++, (*count)++) {
        rows[*count] = nf + (int)g->e[r * n + i];
        columns[*count] = g->S || r == c ? nf + (int)g->e[c * n + i] : -1;
    }
}

static int where(const int *rank, int b, int row, int column) /* in the band; -1 for what is left out */
{
    return row < 0 || column < 0 ? -1 : rank[column] * (3 * b + 1) + 2 * b + rank[row] - rank[column];
}

/* The places of all parts in the band. OK, NO_MEMORY, or ANOTHER_WAY when the band is wide. */
static int band_pattern(const Equilibrium *q, Own *w, int *rows, int *columns, int *places, int *turned)
{
    const int nf = (int)q->nf, n = w->n;
    int count = 0;
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        Piece *p = &w->pieces[k];
        p->at = places + count;
        if (g->curved || g->heavy) pairs_of(w, g, rows, columns, &count);
        p->v_at = places + count; p->turned_at = turned + count; p->c_at = p->v_at + p->v;
        pairs_of_deformations(w, g, nf, rows, columns, &count);
    }
    Graph graph = {0};
    int status = graph_of(&graph, n, rows, columns, count);
    if (status == OK) status = band_order(&graph, w->rank);
    if (status == OK) {
        w->b = band_width(&graph, w->rank);
        if (3 * w->b + 1 >= q->widest && n > q->dense) status = ANOTHER_WAY;
    }
    give_back(&graph.memory);
    if (status != OK) return status;
    for (int k = 0; k < count; k++) {
        places[k] = where(w->rank, w->b, rows[k], columns[k]);
        turned[k] = where(w->rank, w->b, columns[k], rows[k]);
    }
    w->band = cleared(&w->memory, (size_t)n * (3 * w->b + 1), sizeof(double));
    return w->band ? OK : NO_MEMORY;
}

/* Everything that stays. OK, NO_MEMORY, or ANOTHER_WAY. */
static int spacar_equilibrium_begin(Equilibrium *q)
{
    Own *w = q->own = calloc(1, sizeof *w);
    if (!w) return NO_MEMORY;
    const int n = w->n = (int)(q->nf + q->ne);
    w->pieces = cleared(&w->memory, q->n_groups, sizeof(Piece));
    if (!w->pieces) return NO_MEMORY;
    size_t numbers = 8 * (size_t)q->nx + 7 * (size_t)q->ne + 2 * (size_t)n, squares = 0, pairs = 0;
    for (int k = 0; k < q->n_groups; k++) {
        const Elements *t = q->groups[k].elements;
        Piece *p = &w->pieces[k];
        p->square = t->nxe * t->nxe * t->n; p->v = t->nee * t->nxe * t->n; p->c = t->nee * t->nee * t->n;
        numbers += 2 * (size_t)t->nxe * t->n + 3 * (size_t)t->nee * t->n + 3 * (size_t)p->square + p->c;
        squares += p->square;
        pairs += (size_t)p->square + p->v + p->c;
    }
    int *rows = cleared(&w->memory, 4 * pairs + 2 * squares, sizeof(int));
    w->place = cleared(&w->memory, q->nx, sizeof(int));
    w->rank = cleared(&w->memory, n, sizeof(int));
    w->pivots = cleared(&w->memory, n, sizeof(int));
    w->z = cleared(&w->memory, n, sizeof(quad));
    double *d = cleared(&w->memory, numbers, sizeof(double));
    if (!rows || !w->place || !w->rank || !w->pivots || !w->z || !d) return NO_MEMORY;
    int *definite = rows + 4 * pairs, free_coordinates = 0;
    for (int k = 0; k < q->n_groups; k++) {
        const Elements *t = q->groups[k].elements;
        const size_t e = (size_t)t->nee * t->n, x = (size_t)t->nxe * t->n;
        Piece *p = &w->pieces[k];
        p->x = d; p->branch = d + x; p->e = p->branch + e; p->sigma = p->e + e; p->C = p->sigma + e;
        p->H = p->C + p->c; p->by_x = p->H + p->square; d = p->by_x + 2 * p->square;
        p->definite_row = definite; p->definite_column = definite + p->square; definite += 2 * p->square;
    }
    double **vectors[] = { &w->applied, &w->given_x, &w->force, &w->sizes, &w->x, &w->dx, &w->inertia, &w->weight };
    for (int k = 0; k < 8; k++, d += q->nx) *vectors[k] = d;
    double **stresses[] = { &w->given_e, &w->preload, &w->sigma, &w->gap, &w->lengths, &w->before, &w->coupled };
    for (int k = 0; k < 7; k++, d += q->ne) *stresses[k] = d;
    w->right = d; w->rounding = d + n; w->still = d + 2 * n;
    for (int i = 0; i < q->nx; i++)
        w->place[i] = i < q->x_free || (i >= q->x_input && i < q->x_input + q->n_x_input) ? -1 : free_coordinates++;
    const int status = flexibility_of(q, w);
    return status != OK ? status : band_pattern(q, w, rows, rows + pairs, rows + 2 * pairs, rows + 3 * pairs);
}
