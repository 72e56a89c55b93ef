/* Band matrices of one case: an order of the unknowns that makes the band narrow, LU with partial pivoting,
   Cholesky.

   Order: reverse Cuthill-McKee from an end of the graph (A. George, J. W. Liu, "Computer Solution of Large Sparse
   Positive Definite Systems", 1981, chapter 4). Storage of LAPACK's gbtrf with b diagonals on both sides: (i, j) is
   number j (3b + 1) + 2b + i - j. */
typedef double quad __attribute__((vector_size(32), aligned(8), may_alias)); /* four right-hand sides side by side */

typedef struct { int n, *start, *neighbour, *degree; Memory memory; } Graph;

/* The graph of the pairs (rows[k], columns[k]), k < count, both ways, those with a negative number left out. */
static int graph_of(Graph *g, int n, const int *rows, const int *columns, int count)
{
    g->n = n;
    g->start = cleared(&g->memory, n + 2, sizeof(int));
    g->degree = cleared(&g->memory, n + 1, sizeof(int));
    g->neighbour = taken(&g->memory, 2 * (size_t)count + 1, sizeof(int));
    int *seen = taken(&g->memory, n + 1, sizeof(int));
    if (!g->start || !g->degree || !g->neighbour || !seen) return NO_MEMORY;
    for (int k = 0; k < count; k++) if (rows[k] >= 0 && columns[k] >= 0 && rows[k] != columns[k]) {
        g->start[rows[k] + 2]++;
        g->start[columns[k] + 2]++;
    }
    for (int i = 0; i < n; i++) g->start[i + 2] += g->start[i + 1];
    for (int k = 0; k < count; k++) if (rows[k] >= 0 && columns[k] >= 0 && rows[k] != columns[k]) {
        g->neighbour[g->start[rows[k] + 1]++] = columns[k];
        g->neighbour[g->start[columns[k] + 1]++] = rows[k];
    }
    for (int i = 0; i < n; i++) seen[i] = -1;
    for (int i = 0; i < n; i++) /* every neighbour once */
        for (int k = g->start[i]; k < g->start[i + 1]; k++) {
            const int j = g->neighbour[k];
            if (seen[j] == i) continue;
            seen[j] = i;
            g->neighbour[g->start[i] + g->degree[i]++] = j;
        }
    return OK;
}

/* From `first` outwards: the part of the graph that hangs together goes to `order`, `level` counts from 0.
   Neighbours come in the order of their degrees. The number of unknowns; *depth: the number of levels. */
static int spread(const Graph *g, int first, int *order, int *level, int *depth)
{
    int count = 1;
    order[0] = first;
    level[first] = 0;
    for (int k = 0; k < count; k++) {
        const int i = order[k], from = count;
        for (int l = g->start[i]; l < g->start[i] + g->degree[i]; l++) {
            const int j = g->neighbour[l];
            if (level[j] >= 0) continue;
            level[j] = level[i] + 1;
            int at = count++;
            for (; at > from && g->degree[order[at - 1]] > g->degree[j]; at--) order[at] = order[at - 1];
            order[at] = j;
        }
    }
    *depth = level[order[count - 1]] + 1;
    return count;
}

/* The new place of every unknown. */
static int band_order(Graph *g, int *rank)
{
    const int n = g->n;
    int *order = taken(&g->memory, 2 * (size_t)n + 1, sizeof(int)), *level = order + n, done = 0;
    if (!order) return NO_MEMORY;
    for (int i = 0; i < n; i++) level[i] = -1;
    for (int i = 0; i < n; i++) {
        if (level[i] >= 0) continue;
        int depth = 0, *part = order + done, count = spread(g, i, part, level, &depth);
        /* the end that is farthest, of few neighbours, as long as it gets farther */
        for (int tries = 0; tries < 4; tries++) {
            int next = part[count - 1], before = depth;
            for (int k = count - 1; k >= 0 && level[part[k]] == depth - 1; k--)
                if (g->degree[part[k]] < g->degree[next]) next = part[k];
            for (int k = 0; k < count; k++) level[part[k]] = -1;
            spread(g, next, part, level, &depth);
            if (depth <= before) break;
        }
        done += count;
    }
    for (int k = 0; k < n; k++) rank[order[n - 1 - k]] = k;
    return OK;
}

/* The largest distance of two unknowns of the graph. */
static int band_width(const Graph *g, const int *rank)
{
    int width = 0;
    for (int i = 0; i < g->n; i++)
        for (int k = g->start[i]; k < g->start[i] + g->degree[i]; k++) {
            const int distance = abs(rank[i] - rank[g->neighbour[k]]);
            if (distance > width) width = distance;
        }
    return width;
}

/* LU in place; pivots[j]: by how many rows row j was exchanged. OK or SINGULAR. */
static int band_factor(double *a, int n, int b, int *pivots)
{
    const int top = 2 * b, height = 3 * b + 1;
    int last = 0;
    for (int j = 0; j < n; j++) {
        double *restrict column = a + (size_t)j * height + top;
        const int below = b < n - 1 - j ? b : n - 1 - j;
        int p = 0;
        for (int i = 1; i <= below; i++) if (fabs(column[i]) > fabs(column[p])) p = i;
        pivots[j] = p;
        if (column[p] == 0.0) return SINGULAR;
        const int reach = j + b + p < n - 1 ? j + b + p : n - 1;
        if (reach > last) last = reach;
        if (p)
            for (int c = j; c <= last; c++) {
                double *at = a + (size_t)c * height + top + j - c, kept = at[0];
                at[0] = at[p];
                at[p] = kept;
            }
        const double inverse = 1.0 / column[0];
        for (int i = 1; i <= below; i++) column[i] *= inverse;
        for (int c = j + 1; c <= last; c++) {
            double *restrict to = a + (size_t)c * height + top + j - c;
            const double u = to[0];
            if (u == 0.0) continue;
            for (int i = 1; i <= below; i++) to[i] -= u * column[i];
        }
    }
    return OK;
}

/* Solutions of four right-hand sides, in their place. */
static void band_solve(const double *a, int n, int b, const int *pivots, quad *x)
{
    const int top = 2 * b, height = 3 * b + 1;
    for (int j = 0; j < n; j++) {
        const double *column = a + (size_t)j * height + top;
        const int below = b < n - 1 - j ? b : n - 1 - j;
        const quad at = x[j + pivots[j]];
        x[j + pivots[j]] = x[j];
        x[j] = at;
        for (int i = 1; i <= below; i++) x[j + i] -= column[i] * at;
    }
    for (int j = n - 1; j >= 0; j--) {
        const double *column = a + (size_t)j * height + top;
        const quad at = x[j] /= column[0];
        const int above = top < j ? top : j;
        for (int i = 1; i <= above; i++) x[j - i] -= column[-i] * at;
    }
}

/* Sign of the determinant. */
static double band_sign(const double *a, int n, int b, const int *pivots)
{
    int negative = 0;
    for (int j = 0; j < n; j++) negative += (a[(size_t)j * (3 * b + 1) + 2 * b] < 0.0) + (pivots[j] != 0);
    return negative % 2 ? -1.0 : 1.0;
}

/* Has the symmetric matrix a Cholesky factorization? The lower half, (i, j) is number j (w + 1) + i - j. */
static int band_positive(double *a, int n, int w)
{
    for (int j = 0; j < n; j++) {
        double *restrict column = a + (size_t)j * (w + 1);
        const int below = w < n - 1 - j ? w : n - 1 - j;
        if (!(column[0] > 0.0)) return 0;
        const double inverse = 1.0 / sqrt(column[0]);
        for (int i = 1; i <= below; i++) column[i] *= inverse;
        for (int k = 1; k <= below; k++) {
            double *restrict to = a + (size_t)(j + k) * (w + 1) - k;
            const double l = column[k];
            if (l == 0.0) continue;
            for (int i = k; i <= below; i++) to[i] -= l * column[i];
        }
    }
    return 1;
}

/* The diagonal of the inverse by selected_inverse.py, in the order of the band; row pivots[j] was exchanged with j. OK
   or NO_MEMORY. */
static int spacar_band_inverse(const double *a, int n, int b, const int *pivots, double *diagonal)
{
    const int top = 2 * b, height = 3 * b + 1, width = 3 * b < n - 1 ? 3 * b : n - 1, size = 2 * width + 2;
    double *store = calloc((size_t)size * size + 2 * size, sizeof(double));
    if (!store) return NO_MEMORY;
    double *column = store + (size_t)size * size, *restrict line = column + size;
    int at = size; /* place of row and column j + 1 */
    for (int j = n - 1; j >= 0; j--, at--) {
        const int rest = width < n - 1 - j ? width : n - 1 - j, below = b < rest ? b : rest;
        const double *factors = a + (size_t)j * height + top + 1, d = factors[-1];
        if (at == 0) {
            at = size - width;
            for (int i = 0; i < width; i++)
                memcpy(store + (size_t)(at + i) * size + at, store + (size_t)i * size, sizeof(double) * width);
        }
        double *first = store + (size_t)(at - 1) * size + at - 1, product = 1.0;
        memset(line, 0, sizeof(double) * rest);
        for (int k = 0; k < rest; k++) {
            const double *row = first + (size_t)(k + 1) * size + 1;
            const double u = k < top ? factors[(size_t)(k + 1) * height - k - 2] : 0.0; /* of row j */
            quad sum = {0.0};
            int i = 0;
            for (; i + 4 <= below; i += 4) sum += *(const quad *)(row + i) * *(const quad *)(factors + i);
            double z = sum[0] + sum[1] + sum[2] + sum[3];
            for (; i < below; i++) z += row[i] * factors[i];
            column[k] = -z;
            product -= u * column[k];
            if (u != 0.0) for (int c = 0; c < rest; c++) line[c] -= u * row[c];
        }
        first[0] = product / d;
        for (int k = 0; k < rest; k++) {
            first[(size_t)(k + 1) * size] = column[k];
            first[k + 1] = line[k] / d;
        }
        const int p = pivots[j] - j;
        for (int k = 0; p && k <= rest; k++) {
            double *row = first + (size_t)k * size, kept = row[0];
            row[0] = row[p];
            row[p] = kept;
        }
        if (j + width < n) diagonal[j + width] = first[(size_t)width * (size + 1)]; /* out of reach of exchanges */
    }
    for (int i = 0; i < width; i++) diagonal[i] = store[(size_t)(at + i) * (size + 1)];
    free(store);
    return OK;
}
