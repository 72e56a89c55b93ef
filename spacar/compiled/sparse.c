/* Sparse LU with an order of the pivots that is chosen once, from numbers, and used as long as it is good.

   The matrix is a list of entries (row, column, place of the value); entries of the same place add up. Rows are scaled
   by the row factors of an equilibration (Ruiz, RAL-TR-2001-034). The order minimizes the fill (Markowitz) among the
   entries that are at least THRESHOLD of the largest one of their column (Duff, Erisman, Reid, "Direct Methods for Sparse
   Matrices", chapters 5 and 10). A later factorization has no choice; it returns its largest
   multiplier, and above GROWTH, or when that is not a number, the order has to be chosen again. */

enum { OK = 0, NO_CONVERGENCE = -1, SINGULAR = -2, NOT_FINITE = -3, JUMP = -4, NO_MEMORY = -5, NOT_ANSWERED = -6 };
static const double THRESHOLD = 0.1, GROWTH = 100.0;

typedef struct {
    int n, n_entries, planned, even; /* even: sign of the permutations */
    int *row, *column, *source;         /* (n_entries) */
    double *weight;                     /* (n) row factors */
    int *row_order, *column_order;      /* (n) row and column of pivot k */
    int *entry_start, *entry_column, *entry_source; /* entries by pivot row, columns as pivots */
    int *lower_start, *lower_column, *upper_start, *upper_column;
    real *lower, *upper, *inverse, *work; /* `inverse` of the pivots */
} Sparse;

typedef struct { int n, capacity, *index; double *value; } List;

static int append(List *list, int index, double value)
{
    if (list->n == list->capacity) {
        const int capacity = 2 * list->capacity + 8;
        int *indices = realloc(list->index, capacity * sizeof(int));
        if (indices) list->index = indices;
        double *values = realloc(list->value, capacity * sizeof(double));
        if (values) list->value = values;
        if (!indices || !values) return NO_MEMORY;
        list->capacity = capacity;
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

static void free_lists(List *lists, int n)
{
    if (lists) for (int i = 0; i < n; i++) { free(lists[i].index); free(lists[i].value); }
    free(lists);
}

static int sparse_begin(Sparse *s, int n, int n_entries)
{
    s->n = n;
    s->n_entries = n_entries;
    s->row = cleared(n_entries, sizeof(int));
    s->column = cleared(n_entries, sizeof(int));
    s->source = cleared(n_entries, sizeof(int));
    s->weight = cleared(n, sizeof(double));
    s->row_order = cleared(n, sizeof(int));
    s->column_order = cleared(n, sizeof(int));
    s->entry_start = cleared(n + 1, sizeof(int));
    s->entry_column = cleared(n_entries, sizeof(int));
    s->entry_source = cleared(n_entries, sizeof(int));
    s->lower_start = cleared(n + 1, sizeof(int));
    s->upper_start = cleared(n + 1, sizeof(int));
    s->inverse = cleared(n, sizeof(real));
    s->work = cleared(n, sizeof(real));
    return s->row && s->column && s->source && s->weight && s->row_order && s->column_order && s->entry_start
        && s->entry_column && s->entry_source && s->lower_start && s->upper_start && s->inverse && s->work ? OK : NO_MEMORY;
}

/* Room for `width` right-hand sides at a time; one until then. */
static int sparse_widen(Sparse *s, int width)
{
    free(s->work);
    s->work = cleared((size_t)s->n * width, sizeof(real));
    return s->work ? OK : NO_MEMORY;
}

static void sparse_end(Sparse *s)
{
    free(s->row); free(s->column); free(s->source); free(s->weight); free(s->row_order); free(s->column_order);
    free(s->entry_start); free(s->entry_column); free(s->entry_source); free(s->lower_start); free(s->lower_column);
    free(s->upper_start); free(s->upper_column); free(s->lower); free(s->upper); free(s->inverse); free(s->work);
}

/* Row factors, so that after column factors too the largest entries of rows and columns are about 1. */
static int equilibrate(Sparse *s, const real *values, int lane)
{
    const int n = s->n;
    double *column = malloc(3 * n * sizeof(double)), *r = column + n, *c = column + 2 * n;
    if (!column) return NO_MEMORY;
    for (int i = 0; i < n; i++) s->weight[i] = column[i] = 1.0;
    for (int pass = 0; pass < 4; pass++) {
        for (int i = 0; i < 2 * n; i++) r[i] = 0.0;
        for (int k = 0; k < s->n_entries; k++) {
            const int i = s->row[k], j = s->column[k];
            const double size = fabs(LANE(values[s->source[k]], lane)) * s->weight[i] * column[j];
            if (size > r[i]) r[i] = size;
            if (size > c[j]) c[j] = size;
        }
        for (int i = 0; i < n; i++) {
            if (r[i] > 0.0) s->weight[i] /= sqrt(r[i]);
            if (c[i] > 0.0) column[i] /= sqrt(c[i]);
        }
    }
    free(column);
    return OK;
}

/* Numbers of entries in the columns that are left, as a tree of minima, so that a pivot is found without looking at all
   columns: `fewest` of node k is the smaller one of its children 2 k and 2 k + 1, column j is node leaves + j. */
typedef struct { int leaves, *fewest; } Counts;

static int counts_begin(Counts *counts, const List *columns, int n)
{
    for (counts->leaves = 1; counts->leaves < n; ) counts->leaves *= 2;
    counts->fewest = malloc(2 * counts->leaves * sizeof(int));
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
    for (int limit = fewest + 1, searched = 0; ; limit = n + 1) {
        long best = -1;
        double strongest = 0.0;
        for (int j = column_from(counts, 0, limit); j >= 0 && (limit > n || searched < 8);
             j = column_from(counts, j + 1, limit)) {
            double size[columns[j].n], largest = 0.0;
            for (int k = 0; k < columns[j].n; k++) {
                const List *row = &rows[columns[j].index[k]];
                size[k] = fabs(row->value[place_of(row, j)]);
                if (size[k] > largest) largest = size[k];
            }
            if (!(largest > 0.0)) continue;
            if (limit <= n) searched++;
            for (int k = 0; k < columns[j].n; k++) {
                if (!(size[k] >= THRESHOLD * largest)) continue;
                const int i = columns[j].index[k];
                const long cost = (long)(rows[i].n - 1) * (columns[j].n - 1);
                if (best < 0 || cost < best || (cost == best && size[k] > strongest * largest)) {
                    best = cost; strongest = size[k] / largest; *p = i; *q = j;
                }
            }
        }
        if (best >= 0) return OK;
        if (limit > n) return SINGULAR;
    }
}

/* +1 or -1: an even or odd permutation. */
static int parity(const int *order, int n)
{
    int sign = 1;
    char *seen = cleared(n, 1);
    for (int i = 0; seen && i < n; i++) {
        if (seen[i]) continue;
        for (int j = order[i]; j != i; j = order[j]) { seen[j] = 1; sign = -sign; }
    }
    free(seen);
    return sign;
}

/* Choose the order from the values of a lane. OK, SINGULAR or NO_MEMORY. */
static int plan(Sparse *s, const real *values, int lane)
{
    const int n = s->n;
    List *rows = cleared(n, sizeof(List)), *columns = cleared(n, sizeof(List));
    List *lower = cleared(n, sizeof(List)), *upper = cleared(n, sizeof(List));
    Counts counts = {0, NULL};
    int *step = cleared(3 * n, sizeof(int)), *row_step = step + n, *next = step + 2 * n;
    int status = rows && columns && lower && upper && step ? equilibrate(s, values, lane) : NO_MEMORY;
    s->planned = 0;
    for (int k = 0; k < s->n_entries && !status; k++) {
        const int i = s->row[k], j = s->column[k], at = place_of(&rows[i], j);
        const double value = LANE(values[s->source[k]], lane) * s->weight[i];
        if (at >= 0) rows[i].value[at] += value;
        else { status = append(&rows[i], j, value); if (!status) status = append(&columns[j], i, 0.0); }
    }
    if (!status) status = counts_begin(&counts, columns, n);
    for (int k = 0; k < n && !status; k++) {
        int p = 0, q = 0;
        status = choose(rows, columns, &counts, n, &p, &q);
        if (status) break;
        set_count(&counts, q, INT_MAX);
        s->row_order[k] = p;
        s->column_order[k] = q;
        List *row = &rows[p];
        const double pivot = row->value[place_of(row, q)];
        drop(row, place_of(row, q));
        for (int j = 0; j < row->n; j++) {
            List *column = &columns[row->index[j]];
            drop(column, place_of(column, p));
            if (!status) status = append(&upper[k], row->index[j], 0.0);
        }
        for (int m = 0; m < columns[q].n && !status; m++) {
            const int i = columns[q].index[m];
            if (i == p) continue;
            List *below = &rows[i];
            const int at = place_of(below, q);
            const double l = below->value[at] / pivot;
            drop(below, at);
            status = append(&lower[i], k, 0.0);
            for (int j = 0; j < row->n && !status; j++) {
                const int c = row->index[j], there = place_of(below, c);
                if (there >= 0) below->value[there] -= l * row->value[j];
                else {
                    status = append(below, c, -l * row->value[j]);
                    if (!status) status = append(&columns[c], i, 0.0);
                }
            }
        }
        for (int j = 0; j < row->n; j++) set_count(&counts, row->index[j], columns[row->index[j]].n);
    }
    if (!status) {
        int n_lower = 0, n_upper = 0;
        for (int k = 0; k < n; k++) { step[s->column_order[k]] = k; row_step[s->row_order[k]] = k; }
        for (int k = 0; k < n; k++) { n_lower += lower[k].n; n_upper += upper[k].n; }
        free(s->lower_column); free(s->upper_column); free(s->lower); free(s->upper);
        s->lower_column = cleared(n_lower, sizeof(int));
        s->upper_column = cleared(n_upper, sizeof(int));
        s->lower = cleared(n_lower, sizeof(real));
        s->upper = cleared(n_upper, sizeof(real));
        if (!s->lower_column || !s->upper_column || !s->lower || !s->upper) status = NO_MEMORY;
    }
    if (!status) {
        int a = 0, b = 0;
        memset(s->entry_start, 0, (n + 1) * sizeof(int));
        for (int k = 0; k < s->n_entries; k++) s->entry_start[row_step[s->row[k]] + 1]++;
        for (int k = 0; k < n; k++) {
            const List *low = &lower[s->row_order[k]]; /* steps in the order of elimination, so ascending */
            s->entry_start[k + 1] += s->entry_start[k];
            s->lower_start[k] = a;
            s->upper_start[k] = b;
            for (int j = 0; j < low->n; j++) s->lower_column[a++] = low->index[j];
            for (int j = 0; j < upper[k].n; j++) s->upper_column[b++] = step[upper[k].index[j]];
        }
        s->lower_start[n] = a;
        s->upper_start[n] = b;
        memcpy(next, s->entry_start, n * sizeof(int));
        for (int k = 0; k < s->n_entries; k++) {
            const int at = next[row_step[s->row[k]]]++;
            s->entry_column[at] = step[s->column[k]];
            s->entry_source[at] = s->source[k];
        }
        s->planned = 1;
        s->even = parity(s->row_order, n) * parity(s->column_order, n);
    }
    free_lists(rows, n); free_lists(columns, n); free_lists(lower, n); free_lists(upper, n);
    free(counts.fewest); free(step);
    return status;
}

/* Numbers in the chosen order, row by row; the largest multiplier, not a number after a pivot that is zero. */
static real factor_in_order(Sparse *s, const real *values)
{
    const int n = s->n;
    real *w = s->work, growth = EVERY(0.0), zero = EVERY(0.0);
    for (int k = 0; k < n; k++) {
        const int a = s->lower_start[k], b = s->lower_start[k + 1], c = s->upper_start[k], d = s->upper_start[k + 1];
        const double weight = s->weight[s->row_order[k]];
        for (int m = a; m < b; m++) w[s->lower_column[m]] = EVERY(0.0);
        for (int m = c; m < d; m++) w[s->upper_column[m]] = EVERY(0.0);
        w[k] = EVERY(0.0);
        for (int m = s->entry_start[k]; m < s->entry_start[k + 1]; m++)
            w[s->entry_column[m]] += values[s->entry_source[m]] * weight;
        for (int m = a; m < b; m++) {
            const int j = s->lower_column[m];
            const real l = w[j] * s->inverse[j];
            s->lower[m] = l;
            growth = lanes_larger(growth, l);
            for (int u = s->upper_start[j]; u < s->upper_start[j + 1]; u++) w[s->upper_column[u]] -= l * s->upper[u];
        }
        s->inverse[k] = 1.0 / w[k];
        zero += s->inverse[k] * 0.0;
        for (int m = c; m < d; m++) s->upper[m] = w[s->upper_column[m]];
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
    const int status = plan(s, values, worst);
    if (status) return status;
    return largest_lane(factor_in_order(s, values)) <= GROWTH ? OK : SINGULAR;
}

/* x of A x = b; both (n), the same or not. */
static void solve(const Sparse *s, const real *b, real *x)
{
    const int n = s->n;
    real *y = s->work;
    for (int k = 0; k < n; k++) {
        real sum = b[s->row_order[k]] * s->weight[s->row_order[k]];
        for (int m = s->lower_start[k]; m < s->lower_start[k + 1]; m++) sum -= s->lower[m] * y[s->lower_column[m]];
        y[k] = sum;
    }
    for (int k = n - 1; k >= 0; k--) {
        real sum = y[k];
        for (int m = s->upper_start[k]; m < s->upper_start[k + 1]; m++) sum -= s->upper[m] * y[s->upper_column[m]];
        y[k] = sum * s->inverse[k];
    }
    for (int k = 0; k < n; k++) x[s->column_order[k]] = y[k];
}

/* The matrix X of A X = B, both (n, width) and the same, `width` a multiple of ROW. */
static void solve_rows(const Sparse *s, real *x, int width)
{
    const int n = s->n;
    real *y = s->work;
    memset(y, 0, sizeof(real) * n * width);
    for (int k = 0; k < n; k++) {
        add_row(y + k * width, EVERY(s->weight[s->row_order[k]]), x + s->row_order[k] * width, width);
        for (int m = s->lower_start[k]; m < s->lower_start[k + 1]; m++)
            add_row(y + k * width, -s->lower[m], y + s->lower_column[m] * width, width);
    }
    for (int k = n - 1; k >= 0; k--) {
        real *to = x + s->column_order[k] * width;
        for (int m = s->upper_start[k]; m < s->upper_start[k + 1]; m++)
            add_row(y + k * width, -s->upper[m], x + s->column_order[s->upper_column[m]] * width, width);
        memset(to, 0, sizeof(real) * width);
        add_row(to, s->inverse[k], y + k * width, width);
    }
}

/* x of A^T x = b. */
static void solve_transposed(const Sparse *s, const real *b, real *x)
{
    const int n = s->n;
    real *y = s->work;
    for (int k = 0; k < n; k++) y[k] = b[s->column_order[k]];
    for (int k = 0; k < n; k++) {
        y[k] *= s->inverse[k];
        for (int m = s->upper_start[k]; m < s->upper_start[k + 1]; m++) y[s->upper_column[m]] -= s->upper[m] * y[k];
    }
    for (int k = n - 1; k >= 0; k--)
        for (int m = s->lower_start[k]; m < s->lower_start[k + 1]; m++) y[s->lower_column[m]] -= s->lower[m] * y[k];
    for (int k = 0; k < n; k++) x[s->row_order[k]] = y[k] * s->weight[s->row_order[k]];
}

/* frexp of a number, its exponent added to power; the call of frexp would take ten times as long. */
static double split(double value, long *power)
{
    union { double value; unsigned long long bits; } number = { value };
    const int exponent = number.bits >> 52 & 0x7ff;
    if (exponent == 0 || exponent == 0x7ff) { /* zero, subnormal, not finite */
        int part;
        value = frexp(value, &part);
        *power += part;
        return value;
    }
    *power += exponent - 1022;
    number.bits = (number.bits & ~(0x7ffULL << 52)) | 1022ULL << 52;
    return number.value;
}

/* Inverse of the determinant of the factored matrix, lane by lane (LANES each): mantissa 2^exponent. Logarithms would take
   longer than the factorization of a small matrix. */
static void determinant(const Sparse *s, double *mantissa, double *exponent)
{
    EACH_LANE {
        double product = s->even;
        long power = 0;
        for (int k = 0; k < s->n; k++) {
            product = split(product * (LANE(s->inverse[k], w) * s->weight[s->row_order[k]]), &power);
        }
        mantissa[w] = product;
        exponent[w] = power;
    }
}
