/* Small dense matrices of one case, rows one after the other. */

/* LU in place with partial pivoting, rows one after the other; pivots[j]: the row that was exchanged with row j. */
static int dense_factor(double *a, int n, int *pivots)
{
    for (int j = 0; j < n; j++) {
        int p = j;
        for (int i = j + 1; i < n; i++) if (fabs(a[i * n + j]) > fabs(a[p * n + j])) p = i;
        pivots[j] = p;
        if (a[p * n + j] == 0.0) return SINGULAR;
        double *row = a + j * n;
        if (p != j)
            for (int c = 0; c < n; c++) { const double kept = row[c]; row[c] = a[p * n + c]; a[p * n + c] = kept; }
        for (int i = j + 1; i < n; i++) {
            double *to = a + i * n;
            if (to[j] == 0.0) continue;
            const double l = to[j] /= row[j];
            for (int c = j + 1; c < n; c++) to[c] -= l * row[c];
        }
    }
    return OK;
}

/* k right-hand sides, (n, k), in their place. */
static void dense_solve(const double *a, int n, const int *pivots, double *x, int k)
{
    for (int j = 0; j < n; j++) {
        double *at = x + j * k, *other = x + pivots[j] * k;
        if (other != at) for (int c = 0; c < k; c++) { const double kept = at[c]; at[c] = other[c]; other[c] = kept; }
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) {
            const double l = a[i * n + j];
            if (l != 0.0) for (int c = 0; c < k; c++) x[i * k + c] -= l * x[j * k + c];
        }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            const double u = a[i * n + j];
            if (u != 0.0) for (int c = 0; c < k; c++) x[i * k + c] -= u * x[j * k + c];
        }
        for (int c = 0; c < k; c++) x[i * k + c] /= a[i * n + i];
    }
}
