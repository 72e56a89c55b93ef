/* Sparse LU with an order of the pivots that is chosen once, from numbers, and used as long as it is good.

   The matrix is a list of entries (row, column, place of the value); entries of the same place add up. Rows are
   scaled by the row factors of an equilibration (Ruiz, RAL-TR-2001-034). The order minimizes the fill (Markowitz)
   among the entries that are at least THRESHOLD of the largest one of their column (Duff, Erisman, Reid, "Direct
   Methods for Sparse Matrices", chapters 5 and 10). A later factorization has no choice; it returns its largest
   multiplier, and above GROWTH, or when that is not a number, the order has to be chosen again.

   Row k of the factors, in the order of the pivots, begins at row_at[k] with its multipliers, then come the pivot and
   from upper_at[k] on the rest of the row, columns ascending. What is behind the pivot of a row goes into another row
   in runs of neighbouring places (`runs`), few and long where rows have nearly the same columns. */

static const double THRESHOLD = 0.1, GROWTH = 100.0;
enum { SEARCHED = 256 }; /* entries of columns among which a pivot is chosen */

typedef struct {
    /* kept: the order stays, another one is made beside it; even: sign of the permutations */
    int n, planned, kept, even;
    Entries entries;
    double *weight;                     /* (n) row factors */
    int *row_order, *column_order;      /* (n) row and column of pivot k */
    /* of the entries, by pivot row: where they go in the factors, where they come from */
    int *entry_place, *entry_source;
    double *entry_weight;
    Memory order;                       /* what has the order, and the factors in it */
    int *row_at, *upper_at;             /* (n + 1), (n) */
    int *factor_column;                 /* of the factors, as pivots */
    int *runs;                          /* place and length, in the order in which elimination takes them */
    real *factors, *inverse, *work;     /* `inverse` of the pivots */
} Sparse;

typedef struct { int n, capacity, *index; double *value; } List;

static int append(Memory *work, List *list, int index, double value)
{
    if (list->n == list->capacity) {
        const int capacity = 2 * list->capacity + 8;
        double *values = cleared(work, capacity, sizeof(double) + sizeof(int));
        if (!values) return NO_MEMORY;
        int *indices = (int *)(values + capacity);
        for (int k = 0; k < list->n; k++) { indices[k] = list->index[k]; values[k] = list->value[k]; }
        *list = (List){list->n, capacity, indices, values};
    }
    list->index[list->n] = index;
    list->value[list->n++] = value;
    return OK;
}

static int place_of(const List *list, int index)
{
    for (int k = 0; k < list->n; k++) if (list->index[k] == index) return k;
    return -1;
}

static void drop(List *list, int k)
{
    list->n--;
    list->index[k] = list->index[list->n];
    list->value[k] = list->value[list->n];
}

/* Room for another order of the pivots. */
static int order_begin(Sparse *s)
{
    const int n = s->n, n_entries = s->entries.n;
    if (s->kept) s->order = (Memory){0};
    give_back(&s->order);
    s->planned = s->kept = 0;
    s->weight = cleared(&s->order, n, sizeof(double));
    s->row_order = cleared(&s->order, n, sizeof(int));
    s->column_order = cleared(&s->order, n, sizeof(int));
    s->entry_place = cleared(&s->order, n_entries, sizeof(int));
    s->entry_source = cleared(&s->order, n_entries, sizeof(int));
    s->entry_weight = cleared(&s->order, n_entries, sizeof(double));
    s->row_at = cleared(&s->order, n + 1, sizeof(int));
    s->upper_at = cleared(&s->order, n, sizeof(int));
    return s->weight && s->row_order && s->column_order && s->entry_place && s->entry_source && s->entry_weight
        && s->row_at
        && s->upper_at ? OK : NO_MEMORY;
}

/* A matrix of n rows without entries yet, and room for so many, for one right-hand side. OK or NO_MEMORY. */
static int sparse_begin(Memory *memory, Sparse *s, int n, int capacity)
{
    s->n = n;
    s->inverse = cleared(memory, n, sizeof(real));
    s->work = cleared(memory, n, sizeof(real));
    return s->inverse && s->work ? entries_begin(memory, &s->entries, capacity) : NO_MEMORY;
}

/* The order of the first call, or that it chose none, which is kept; `first` has been cleared then. */
static void first_order(Sparse *s, Sparse *first)
{
    if (first->n) {
        if (!s->kept) give_back(&s->order);
        *s = *first;
    } else if (s->n) {
        s->kept = 1;
        *first = *s;
    }
}

/* `first` as above. What `sparse_begin` has taken is not given back here. */
static void sparse_end(Sparse *s, Sparse *first)
{
    if (!s->kept) give_back(&first->order);
    give_back(&s->order);
}

/* Row factors, so that after column factors too the largest entries of rows and columns are about 1. */
static int equilibrate(Memory *work, Sparse *s, const real *values, int lane)
{
    const int n = s->n;
    double *column = cleared(work, 3 * (size_t)n, sizeof(double)), *r = column + n, *c = column + 2 * n;
    if (!column) return NO_MEMORY;
    for (int i = 0; i < n; i++) s->weight[i] = column[i] = 1.0;
    for (int pass = 0; pass < 4; pass++) {
        for (int i = 0; i < 2 * n; i++) r[i] = 0.0;
        for (int k = 0; k < s->entries.n; k++) {
            const int i = s->entries.row[k], j = s->entries.column[k];
            const double size = fabs(LANE(values[s->entries.source[k]], lane)) * s->weight[i] * column[j];
            if (size > r[i]) r[i] = size;
            if (size > c[j]) c[j] = size;
        }
        for (int i = 0; i < n; i++) {
            if (r[i] > 0.0) s->weight[i] /= sqrt(r[i]);
            if (c[i] > 0.0) column[i] /= sqrt(c[i]);
        }
    }
    return OK;
}

/* Numbers of entries in the columns that are left, as a tree of minima, so that a pivot is found without looking at all
   columns: `fewest` of node k is the smaller one of its children 2 k and 2 k + 1, column j is node leaves + j. */
typedef struct { int leaves, *fewest; } Counts;

static int counts_begin(Memory *work, Counts *counts, const List *columns, int n)
{
    for (counts->leaves = 1; counts->leaves < n; ) counts->leaves *= 2;
    counts->fewest = cleared(work, 2 * (size_t)counts->leaves, sizeof(int));
    if (!counts->fewest) return NO_MEMORY;
    for (int j = 0; j < counts->leaves; j++) counts->fewest[counts->leaves + j] = j < n ? columns[j].n : INT_MAX;
    for (int k = counts->leaves - 1; k > 0; k--) {
        const int left = counts->fewest[2 * k], right = counts->fewest[2 * k + 1];
        counts->fewest[k] = left < right ? left : right;
    }
    return OK;
}

static void set_count(Counts *counts, int j, int count)
{
    int *fewest = counts->fewest, k = counts->leaves + j;
    fewest[k] = count;
    for (k /= 2; k > 0; k /= 2) fewest[k] = fewest[2 * k] < fewest[2 * k + 1] ? fewest[2 * k] : fewest[2 * k + 1];
}

/* The first column from j on with at most `limit` entries, -1 when there is none. */
static int column_from(const Counts *counts, int j, int limit)
{
    if (j >= counts->leaves) return -1;
    int k = counts->leaves + j;
    while (counts->fewest[k] > limit) {
        while (k & 1) { if (k == 1) return -1; k /= 2; }
        k++;
    }
    while (k < counts->leaves) k = counts->fewest[2 * k] <= limit ? 2 * k : 2 * k + 1;
    return k - counts->leaves;
}

/* The pivot with the least fill: step k takes row *p, column *q. */
static int choose(const List *rows, const List *columns, const Counts *counts, int n, int *p, int *q)
{
    const int fewest = counts->fewest[1];
    for (int limit = fewest + 1, searched = 0, entries = 0; ; limit = n + 1) {
        long best = -1;
        double strongest = 0.0;
        for (int j = column_from(counts, 0, limit); j >= 0 && (limit > n || (searched < 8 && entries < SEARCHED));
             j = column_from(counts, j + 1, limit)) {
            const List *column = &columns[j];
            double largest = 0.0;
            for (int k = 0; k < column->n; k++) if (fabs(column->value[k]) > largest) largest = fabs(column->value[k]);
            if (!(largest > 0.0)) continue;
            if (limit <= n) { searched++; entries += column->n; }
            for (int k = 0; k < column->n; k++) {
                const double size = fabs(column->value[k]);
                if (!(size >= THRESHOLD * largest)) continue;
                const int i = column->index[k];
                const long cost = (long)(rows[i].n - 1) * (column->n - 1);
                if (best < 0 || cost < best || (cost == best && size > strongest * largest)) {
                    best = cost; strongest = size / largest; *p = i; *q = j;
                }
            }
        }
        if (best >= 0) return OK;
        if (limit > n) return SINGULAR;
    }
}

/* +1 or -1: an even or odd permutation. */
static int parity(Memory *work, const int *order, int n)
{
    int sign = 1;
    char *seen = cleared(work, n, 1);
    for (int i = 0; seen && i < n; i++) {
        if (seen[i]) continue;
        for (int j = order[i]; j != i; j = order[j]) { seen[j] = 1; sign = -sign; }
    }
    return sign;
}

static int ascending(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

/* The runs of a row behind its pivot in another row, whose columns have these places: their number, and they themselves
   into `to` unless it is NULL. */
static size_t runs_in(const Sparse *s, int above, const int *place, int *to)
{
    size_t n = 0;
    const int *column = s->factor_column;
    for (int u = s->upper_at[above], end = s->row_at[above + 1]; u < end; n++) {
        const int first = u, at = place[column[u]];
        while (u < end && place[column[u]] == at + u - first) u++;
        if (to) { to[2 * n] = at; to[2 * n + 1] = u - first; }
    }
    return n;
}

/* The places of all numbers of the factors, and which of them are changed when. `step` (n): the pivot of a column;
   `work` is for work. OK or NO_MEMORY. */
static int lay_out(Memory *work, Sparse *s, const List *lower, const List *upper, const int *step)
{
    const int n = s->n;
    const Entries *entries = &s->entries;
    int at = 0;
    for (int k = 0; k < n; k++) {
        s->row_at[k] = at;
        s->upper_at[k] = at + lower[s->row_order[k]].n + 1; /* steps in the order of elimination, so ascending */
        at = s->upper_at[k] + upper[k].n;
    }
    s->row_at[n] = at;
    s->factor_column = cleared(&s->order, at, sizeof(int));
    s->factors = cleared(&s->order, at, sizeof(real));
    /* places of the columns of a row; entries of a row, and one behind another */
    int *place = cleared(work, 2 * (size_t)n + entries->n, sizeof(int)), *first = place + n, *next = first + n;
    if (!s->factor_column || !s->factors || !place) return NO_MEMORY;
    for (int i = 0; i < n; i++) first[i] = -1;
    for (int k = entries->n - 1; k >= 0; k--) { next[k] = first[entries->row[k]]; first[entries->row[k]] = k; }
    size_t count = 0;
    for (int store = 0, entry = 0; store < 2; store++) {
        if (store && !(s->runs = cleared(&s->order, 2 * count, sizeof(int)))) return NO_MEMORY;
        int *to = s->runs;
        for (int k = 0; k < n; k++) {
            const int i = s->row_order[k];
            const List *low = &lower[i];
            int *column = s->factor_column + s->row_at[k];
            if (!store) {
                memcpy(column, low->index, sizeof(int) * low->n);
                column[low->n] = k;
                for (int j = 0; j < upper[k].n; j++) column[low->n + 1 + j] = step[upper[k].index[j]];
                qsort(column + low->n + 1, upper[k].n, sizeof(int), ascending);
            }
            for (int f = s->row_at[k]; f < s->row_at[k + 1]; f++) place[s->factor_column[f]] = f;
            for (int j = 0; j < low->n; j++) {
                const size_t found = runs_in(s, low->index[j], place, store ? to : NULL);
                if (store) to += 2 * found; else count += found;
            }
            for (int e = first[i]; store && e >= 0; e = next[e], entry++) {
                s->entry_place[entry] = place[step[entries->column[e]]];
                s->entry_source[entry] = entries->source[e];
                s->entry_weight[entry] = s->weight[i];
            }
        }
    }
    s->planned = 1;
    s->even = parity(work, s->row_order, n) * parity(work, s->column_order, n);
    return OK;
}

/* Choose the order from the values of a lane: what is left has its values by columns and its pattern by rows, and every
   search runs along a row or column that the pivot changes. OK, SINGULAR, NO_MEMORY, or MUCH_WORK where the factors
   take more than `most` multiplications. */
static int plan(Sparse *s, const real *values, int lane, double most)
{
    const int n = s->n;
    if (order_begin(s)) return NO_MEMORY;
    Memory work = {0};
    List *rows = cleared(&work, 4 * (size_t)n, sizeof(List)), *columns = rows + n, *lower = columns + n,
        *upper = lower + n;
    Counts counts = {0, NULL};
    /* place: of a row in a column, plus 1; 0: none */
    int *step = cleared(&work, 2 * (size_t)n, sizeof(int)), *place = step + n;
    int status = rows && step ? equilibrate(&work, s, values, lane) : NO_MEMORY;
    for (int k = 0; k < s->entries.n && !status; k++) {
        const int i = s->entries.row[k], j = s->entries.column[k], at = place_of(&columns[j], i);
        const double value = LANE(values[s->entries.source[k]], lane) * s->weight[i];
        if (at >= 0) columns[j].value[at] += value;
        else { status = append(&work, &columns[j], i, value); if (!status) status = append(&work, &rows[i], j, 0.0); }
    }
    if (!status) status = counts_begin(&work, &counts, columns, n);
    for (int k = 0; k < n && !status; k++) {
        int p = 0, q = 0;
        status = choose(rows, columns, &counts, n, &p, &q);
        if (status) break;
        if ((most -= (rows[p].n - 1.0) * (columns[q].n - 1.0)) < 0.0) { status = MUCH_WORK; break; }
        set_count(&counts, q, INT_MAX);
        s->row_order[k] = p;
        s->column_order[k] = q;
        List *row = &rows[p], *below = &columns[q];
        const int at = place_of(below, p);
        const double pivot = below->value[at];
        drop(below, at);
        drop(row, place_of(row, q));
        upper[k] = *row;
        for (int m = 0; m < below->n && !status; m++) {
            List *other = &rows[below->index[m]];
            drop(other, place_of(other, q));
            status = append(&work, &lower[below->index[m]], k, 0.0);
        }
        for (int j = 0; j < row->n && !status; j++) {
            List *column = &columns[row->index[j]];
            const int here = place_of(column, p);
            const double factor = column->value[here] / pivot;
            drop(column, here);
            const int before = column->n;
            for (int m = 0; m < before; m++) place[column->index[m]] = m + 1;
            for (int m = 0; m < below->n && !status; m++) {
                const int i = below->index[m], there = place[i] - 1;
                if (there >= 0) column->value[there] -= below->value[m] * factor;
                else {
                    status = append(&work, column, i, -below->value[m] * factor);
                    if (!status) status = append(&work, &rows[i], row->index[j], 0.0);
                }
            }
            for (int m = 0; m < before; m++) place[column->index[m]] = 0;
            set_count(&counts, row->index[j], column->n);
        }
    }
    if (!status) {
        for (int k = 0; k < n; k++) step[s->column_order[k]] = k;
        status = lay_out(&work, s, lower, upper, step);
    }
    give_back(&work);
    return status;
}

/* Numbers in the chosen order, row by row; the largest multiplier, not a number after a pivot that is zero. Runs are
   short: loops over them cost more when the compiler makes vectors of them. */
__attribute__((optimize("no-tree-vectorize"))) static real factor_in_order(Sparse *s, const real *values)
{
    real *f = s->factors, growth = EVERY(0.0), zero = EVERY(0.0);
    const int *run = s->runs;
    memset(f, 0, sizeof(real) * s->row_at[s->n]);
    for (int m = 0; m < s->entries.n; m++) f[s->entry_place[m]] += values[s->entry_source[m]] * s->entry_weight[m];
    for (int k = 0; k < s->n; k++) {
        const int pivot = s->upper_at[k] - 1;
        for (int m = s->row_at[k]; m < pivot; m++) {
            const int j = s->factor_column[m];
            const real l = f[m] * s->inverse[j];
            f[m] = l;
            growth = lanes_larger(growth, l);
            for (const real *u = f + s->upper_at[j], *last = f + s->row_at[j + 1]; u < last; run += 2) {
                real *to = f + run[0];
                int count = run[1];
                do *to++ -= l * *u++; while (--count);
            }
        }
        s->inverse[k] = 1.0 / f[pivot];
        zero += s->inverse[k] * 0.0;
    }
    return growth + zero;
}

/* OK, SINGULAR or NO_MEMORY; a new order is chosen where the old one is not good any more. */
static int factor(Sparse *s, const real *values)
{
    real growth = EVERY(0.0);
    if (s->planned) {
        growth = factor_in_order(s, values);
        if (largest_lane(growth) <= GROWTH) return OK;
    }
    int worst = 0;
    EACH_LANE if (!(LANE(growth, w) <= LANE(growth, worst))) worst = w;
    const int status = plan(s, values, worst, INFINITY);
    if (status) return status;
    return largest_lane(factor_in_order(s, values)) <= GROWTH ? OK : SINGULAR;
}
