/* What is not LAPACK's of two problems of small dense matrices: the symmetric definite one, A z = value B z (spacar/linear/buckling.py,
   eigen.py), and the compliances w K^-1 w (buckling.py). Rows one after the other; formulas, criteria and constants are those of Python,
   which takes what ends with ANOTHER_WAY. */
typedef struct {
    const double *a, *b, *scale;  /* (n, n), (n, n), (n): A and B are scaled with it from both sides */
    double *A, *B, *U, *reduced;  /* (n, n) each: both scaled, the factor of B = U^T U, U^-T A U^-1 */
    int64_t n;
    double symmetric, least;      /* relative asymmetry, square of a pivot: those that count as rounding */
} Pencil;

/* As `is_symmetric` of eigen.py; no where the diagonal is zero. */
static int pencil_is_symmetric(const double *a, int n, double most, double *room)
{
    double largest = 0.0, difference = 0.0, size = 0.0;
    for (int i = 0; i < n; i++) largest = larger(largest, room[i] = sqrt(fabs(a[i * n + i])));
    if (!(largest > 0.0)) return 0;
    for (int i = 0; i < n; i++) room[i] = 1.0 / (room[i] > 0.0 ? room[i] : largest);
    for (int i = 0; i < n; i++) for (int j = 0; j <= i; j++) {
        const double scale = room[i] * room[j], below = a[i * n + j] * scale, above = a[j * n + i] * scale;
        difference = larger(difference, below - above);
        size = larger(larger(size, below), above);
    }
    return difference <= most || difference <= most * size;
}

/* x (n, m) becomes U^-T x. */
static void pencil_forward(const double *U, double *x, int n, int m)
{
    for (int i = 0; i < n; i++) {
        double *restrict to = x + i * m;
        for (int j = 0; j < i; j++) {
            const double *restrict from = x + j * m;
            const double u = U[j * n + i];
            if (u != 0.0) for (int c = 0; c < m; c++) to[c] -= u * from[c];
        }
        const double inverse = 1.0 / U[i * n + i];
        for (int c = 0; c < m; c++) to[c] *= inverse;
    }
}

/* The scaled matrices, the factor and the reduced matrix. ANOTHER_WAY: one is not symmetric, or B is not definite. */
static int spacar_pencil_reduce(Pencil *p)
{
    const int n = (int)p->n;
    double *A = p->A, *B = p->B, *U = p->U, *R = p->reduced;
    if (!pencil_is_symmetric(p->a, n, p->symmetric, R) || !pencil_is_symmetric(p->b, n, p->symmetric, R)) return ANOTHER_WAY;
    for (int i = 0; i < n; i++) for (int j = 0; j < n; j++) {
        const double scale = p->scale[i] * p->scale[j];
        A[i * n + j] = p->a[i * n + j] * scale;
        B[i * n + j] = p->b[i * n + j] * scale;
    }
    for (int i = 0; i < n; i++) for (int j = 0; j < n; j++) U[i * n + j] = j < i ? 0.0 : B[j * n + i];
    for (int j = 0; j < n; j++) {
        double *restrict row = U + j * n;
        if (!(row[j] > 0.0 && row[j] > p->least && row[j] < INFINITY)) return ANOTHER_WAY;
        const double root = sqrt(row[j]);
        row[j] = root;
        for (int c = j + 1; c < n; c++) row[c] /= root;
        for (int i = j + 1; i < n; i++) {
            double *restrict to = U + i * n;
            const double u = row[i];
            if (u != 0.0) for (int c = i; c < n; c++) to[c] -= u * row[c];
        }
    }
    memcpy(R, A, sizeof(double) * n * n);
    for (int turn = 0; turn < 2; turn++) {
        pencil_forward(U, R, n, n);
        for (int i = 0; i < n; i++) for (int j = 0; j < i; j++) {
            const double kept = R[i * n + j], other = R[j * n + i];
            R[i * n + j] = turn ? (kept + other) / 2.0 : other;
            R[j * n + i] = turn ? (kept + other) / 2.0 : kept;
        }
    }
    return OK;
}

/* Vectors (n, n) of the reduced matrix become those of the pair, not scaled. */
static void spacar_pencil_back(const Pencil *p, double *vectors)
{
    const int n = (int)p->n;
    for (int i = n - 1; i >= 0; i--) {
        double *restrict to = vectors + i * n;
        const double *row = p->U + i * n;
        for (int j = i + 1; j < n; j++) {
            const double *restrict from = vectors + j * n;
            if (row[j] != 0.0) for (int c = 0; c < n; c++) to[c] -= row[j] * from[c];
        }
        for (int c = 0; c < n; c++) to[c] /= row[i];
    }
    for (int i = 0; i < n; i++) for (int c = 0; c < n; c++) vectors[i * n + c] *= p->scale[i];
}

/* The backward error (m) of values (m), vectors (n, m): spacar/linear/backward_error.py. */
static int spacar_pencil_error(const Pencil *p, const double *values, const double *vectors, double *error, int64_t count)
{
    const int n = (int)p->n, m = (int)count;
    double of_A = 0.0, of_B = 0.0, *room = malloc(((size_t)n + 4) * m * sizeof(double));
    if (!room) return NO_MEMORY;
    double *z = room, *restrict Az = z + n * m, *restrict Bz = Az + m, *restrict size = Bz + m, *restrict residual = size + m;
    for (int i = 0; i < n * n; i++) { of_A += p->A[i] * p->A[i]; of_B += p->B[i] * p->B[i]; }
    of_A = sqrt(of_A); of_B = sqrt(of_B);
    memset(size, 0, 2 * sizeof(double) * m);
    for (int i = 0; i < n; i++) for (int c = 0; c < m; c++) {
        const double entry = z[i * m + c] = vectors[i * m + c] / p->scale[i];
        size[c] += entry * entry;
    }
    for (int i = 0; i < n; i++) {
        memset(Az, 0, 2 * sizeof(double) * m);
        for (int j = 0; j < n; j++) {
            const double *restrict from = z + j * m, a = p->A[i * n + j], b = p->B[i * n + j];
            if (a != 0.0 || b != 0.0) for (int c = 0; c < m; c++) { Az[c] += a * from[c]; Bz[c] += b * from[c]; }
        }
        for (int c = 0; c < m; c++) {
            const double rest = Az[c] - Bz[c] * values[c];
            residual[c] += rest * rest;
        }
    }
    for (int c = 0; c < m; c++) {
        const double bound = (of_A + fabs(values[c]) * of_B) * sqrt(size[c]);
        error[c] = sqrt(residual[c]) / (bound > 0.0 ? bound : 1.0);
    }
    free(room);
    return OK;
}

typedef struct {
    const double *K, *W;  /* (n, n), (nx, n) */
    double *out;          /* (nx) */
    int64_t n, nx;
    double small, most;   /* part of the largest size that is none; condition from which singular values decide */
} Compliances;

/* ANOTHER_WAY: K is singular, or may be. */
static int spacar_compliances(const Compliances *c)
{
    const int n = (int)c->n;
    double largest = 0.0, of_K = 0.0, of_own = 0.0;
    double *K = calloc(2 * (size_t)n * n + 3 * (size_t)n + 1, sizeof(double)), *restrict own = K + n * n, *scale = own + n * n, *w = scale + n;
    double *restrict row = w + n;
    int *pivots = malloc((n + 1) * sizeof(int)), status = NO_MEMORY;
    if (!K || !pivots) goto end;
    for (int i = 0; i < n; i++) largest = larger(largest, scale[i] = sqrt(fabs(c->K[i * n + i])));
    for (int i = 0; i < n; i++) scale[i] = 1.0 / (scale[i] > c->small * largest ? scale[i] : largest > 0.0 ? largest : 1.0);
    for (int i = 0; i < n; i++) {
        own[i * n + i] = 1.0;
        for (int j = 0; j < n; j++) {
            K[i * n + j] = c->K[i * n + j] * (scale[i] * scale[j]);
            of_K += K[i * n + j] * K[i * n + j];
        }
    }
    status = ANOTHER_WAY;
    if (dense_factor(K, n, pivots) != OK) goto end;
    dense_solve(K, n, pivots, own, n);
    for (int i = 0; i < n * n; i++) of_own += own[i] * own[i];
    if (!(sqrt(of_K) * sqrt(of_own) < c->most)) goto end;
    for (int64_t x = 0; x < c->nx; x++) {
        double sum = 0.0;
        memset(row, 0, n * sizeof(double));
        for (int i = 0; i < n; i++) w[i] = c->W[x * n + i] * scale[i];
        for (int i = 0; i < n; i++) if (w[i] != 0.0) for (int j = 0; j < n; j++) row[j] += w[i] * own[i * n + j];
        for (int i = 0; i < n; i++) sum += row[i] * w[i];
        c->out[x] = sum;
    }
    status = OK;
end:
    free(K);
    free(pivots);
    return status;
}
