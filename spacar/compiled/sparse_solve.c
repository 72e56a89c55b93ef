/* Solutions with the factors of sparse.c, and their determinant. */

/* x of A x = b; both (n), the same or not. */
static void solve(const Sparse *s, const real *b, real *x)
{
    const int n = s->n, *column = s->factor_column;
    const real *f = s->factors;
    real *y = s->work;
    for (int k = 0, m = 0; k < n; k++) {
        const int i = s->row_order[k], pivot = s->upper_at[k] - 1;
        real sum = b[i] * s->weight[i];
        for (; m < pivot; m++) sum -= f[m] * y[column[m]];
        y[k] = sum;
        m = s->row_at[k + 1];
    }
    for (int k = n - 1; k >= 0; k--) {
        const int end = s->row_at[k + 1];
        real sum = y[k];
        for (int m = s->upper_at[k]; m < end; m++) sum -= f[m] * y[column[m]];
        y[k] = sum * s->inverse[k];
    }
    for (int k = 0; k < n; k++) x[s->column_order[k]] = y[k];
}

/* `parts` columns of ROW numbers of the following, from x on; a constant, so that the sums stay in registers. */
static inline __attribute__((always_inline)) void solve_parts(const Sparse *s, real *x, int width, const int parts)
{
    const int n = s->n, *column = s->factor_column;
    const real *f = s->factors;
    row_part *y = (row_part *)s->work, sum[parts];
    for (int k = 0, m = 0; k < n; k++) {
        const int i = s->row_order[k], pivot = s->upper_at[k] - 1;
        const row_part *b = (const row_part *)(x + i * width);
        for (int p = 0; p < parts; p++) sum[p] = b[p] * s->weight[i];
        for (; m < pivot; m++) {
            const row_part *above = y + column[m] * parts;
            for (int p = 0; p < parts; p++) sum[p] -= f[m] * above[p];
        }
        for (int p = 0; p < parts; p++) y[k * parts + p] = sum[p];
        m = s->row_at[k + 1];
    }
    for (int k = n - 1; k >= 0; k--) {
        const int end = s->row_at[k + 1];
        row_part *to = (row_part *)(x + s->column_order[k] * width);
        for (int p = 0; p < parts; p++) sum[p] = y[k * parts + p];
        for (int m = s->upper_at[k]; m < end; m++) {
            const row_part *below = y + column[m] * parts;
            for (int p = 0; p < parts; p++) sum[p] -= f[m] * below[p];
        }
        for (int p = 0; p < parts; p++) to[p] = y[k * parts + p] = sum[p] * s->inverse[k];
    }
}

/* The matrix X of A X = B, both (n, width) and the same, `width` a multiple of ROW. */
static void solve_rows(const Sparse *s, real *x, int width)
{
    int c = 0;
    for (; c + 4 * ROW <= width; c += 4 * ROW) solve_parts(s, x + c, width, 4);
    for (; c + 2 * ROW <= width; c += 2 * ROW) solve_parts(s, x + c, width, 2);
    for (; c < width; c += ROW) solve_parts(s, x + c, width, 1);
}

/* x of A^T x = b. */
static void solve_transposed(const Sparse *s, const real *b, real *x)
{
    const int n = s->n, *column = s->factor_column;
    const real *f = s->factors;
    real *y = s->work;
    for (int k = 0; k < n; k++) y[k] = b[s->column_order[k]];
    for (int k = 0; k < n; k++) {
        y[k] *= s->inverse[k];
        for (int m = s->upper_at[k]; m < s->row_at[k + 1]; m++) y[column[m]] -= f[m] * y[k];
    }
    for (int k = n - 1; k >= 0; k--)
        for (int m = s->row_at[k]; m < s->upper_at[k] - 1; m++) y[column[m]] -= f[m] * y[k];
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

/* Inverse of the determinant of the factored matrix, lane by lane (LANES each): mantissa 2^exponent. Logarithms
   would take longer than the factorization of a small matrix. */
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
