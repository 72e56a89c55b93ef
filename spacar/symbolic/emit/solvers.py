"""Program text that solves I a − Jᵀ λ = b, J a = −h with dependent speeds chosen by pivoting at every call.

With D = diag(I)^(−1/2) the speeds are counted in mass units, Î = D I D, Ĵ = J D, rows of Ĵ scaled to largest entry 1.
Gauss-Jordan elimination with complete pivoting gives E Ĵ = [1 | B]: the pivot columns are the dependent speeds,
a_d = −B a_i − E h. In the independent ones Tᵀ Î T a_i = Tᵀ (b − Î t) is solved by LDLᵀ, and λ = Eᵀ (Î a − b)_d.
A pivot below 8 n ε of the entries is no pivot: the constraints depend on each other at this position.
Source: `symbolic.md`, sections 3.5 and 5.
"""

PYTHON = '''
class Dependent(ArithmeticError):
    """The constraints depend on each other at this position."""


def constrained(M, f, J, h):
    """a, l of M a - J^T l = f, J a = -h (f, h may have columns); dependent speeds are chosen by pivoting."""
    m, n = J.shape
    diagonal = M.diagonal()
    D = 1.0/np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    M, f, J = D[:, None]*M*D, (f.T*D).T, J*D
    size = np.abs(J).max(axis=1)
    if not size.min() > 0.0:
        raise Dependent(DEPENDENT)
    E, B, free, open_rows, pivots = np.diag(1.0/size), J/size[:, None], np.ones(n), np.ones(m), [0]*m
    for _ in range(m):
        at = np.abs(B)*open_rows[:, None]*free
        row, column = divmod(int(at.argmax()), n)
        if not at[row, column] > 8.0*n*2.3e-16:
            raise Dependent(DEPENDENT)
        pivots[row], open_rows[row], free[column] = column, 0.0, 0.0
        E[row] /= B[row, column]
        B[row] /= B[row, column]
        factor = B[:, column].copy()
        factor[row] = 0.0
        E -= factor[:, None]*E[row]
        B -= factor[:, None]*B[row]
    kept = np.flatnonzero(free)
    T, t = np.zeros((n, n - m)), np.zeros(f.shape)
    T[kept, np.arange(n - m)] = 1.0
    T[pivots] = -B[:, kept]
    t[pivots] = -(E @ h)
    try:
        L = np.linalg.cholesky(T.T @ M @ T)
    except np.linalg.LinAlgError:
        raise ArithmeticError(INDEFINITE) from None
    a = T @ np.linalg.solve(L.T, np.linalg.solve(L, T.T @ (f - M @ t))) + t
    return (a.T*D).T, E.T @ (M @ a - f)[pivots]


INDEFINITE = 'mass matrix is not positive definite on the motions that the constraints leave'
DEPENDENT = 'the constraints depend on each other at this position'
'''

SOLVE = """\
/* LDL^T of M (n x n) without pivoting, M overwritten; m columns of b, row by row, become the solution. */
static int solve(int n, double *M, double *b, int m)
{
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < j; k++) M[j*n + j] -= M[j*n + k]*M[j*n + k]*M[k*n + k];
        if (!(M[j*n + j] > 0.0)) return j + 1;
        for (int i = j + 1; i < n; i++) {
            for (int k = 0; k < j; k++) M[i*n + j] -= M[i*n + k]*M[k*n + k]*M[j*n + k];
            M[i*n + j] /= M[j*n + j];
        }
    }
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            for (int h = 0; h < m; h++) b[i*m + h] -= M[i*n + k]*b[k*m + h];
    for (int i = n - 1; i >= 0; i--) {
        for (int h = 0; h < m; h++) b[i*m + h] /= M[i*n + i];
        for (int k = i + 1; k < n; k++)
            for (int h = 0; h < m; h++) b[i*m + h] -= M[k*n + i]*b[k*m + h];
    }
    return 0;
}
"""

CONSTRAINED = """\
/* M a - J^T l = b, J a = -h for k columns, row by row; b becomes a, h becomes l. M and J are overwritten.
   Dependent speeds are chosen by pivoting. Returns j when the pivot of speed j is not positive, -1 when the
   constraints depend on each other. */
static int constrained(double *M, double *J, double *b, double *h, int k)
{
    double d[N], E[NM*NM], B[NM*N], A[N*N], x[N], t[N*k], a[N*k];
    int pivot[NM], done[NM], dependent[N], kept[N], nk = 0;
    for (int i = 0; i < N; i++) d[i] = M[i*N + i] > 0.0 ? 1.0/sqrt(M[i*N + i]) : 1.0;
    for (int i = 0; i < N; i++) {
        dependent[i] = 0;
        for (int j = 0; j < N; j++) M[i*N + j] *= d[i]*d[j];
        for (int c = 0; c < k; c++) b[i*k + c] *= d[i];
    }
    for (int r = 0; r < NM; r++) {
        double size = 0.0;
        done[r] = 0;
        for (int j = 0; j < N; j++) { J[r*N + j] *= d[j]; size = fmax(size, fabs(J[r*N + j])); }
        if (!(size > 0.0)) return -1;
        for (int j = 0; j < N; j++) B[r*N + j] = J[r*N + j]/size;
        for (int q = 0; q < NM; q++) E[r*NM + q] = q == r ? 1.0/size : 0.0;
    }
    for (int step = 0; step < NM; step++) {
        double best = 8.0*N*2.3e-16;
        int row = -1, column = 0;
        for (int r = 0; r < NM; r++)
            for (int j = 0; j < N && !done[r]; j++)
                if (!dependent[j] && fabs(B[r*N + j]) > best) { best = fabs(B[r*N + j]); row = r; column = j; }
        if (row < 0) return -1;
        done[row] = 1; dependent[column] = 1; pivot[row] = column;
        const double by = B[row*N + column];
        for (int j = 0; j < N; j++) B[row*N + j] /= by;
        for (int q = 0; q < NM; q++) E[row*NM + q] /= by;
        for (int r = 0; r < NM; r++) {
            const double factor = B[r*N + column];
            if (r == row || factor == 0.0) continue;
            for (int j = 0; j < N; j++) B[r*N + j] -= factor*B[row*N + j];
            for (int q = 0; q < NM; q++) E[r*NM + q] -= factor*E[row*NM + q];
        }
    }
    for (int i = 0; i < N; i++) if (!dependent[i]) kept[nk++] = i;
    /* A = T^T M T, with MT = M T in two steps */
    for (int i = 0; i < nk; i++) {
        for (int r = 0; r < N; r++) {
            x[r] = M[r*N + kept[i]];
            for (int q = 0; q < NM; q++) x[r] -= M[r*N + pivot[q]]*B[q*N + kept[i]];
        }
        for (int j = 0; j < nk; j++) {
            A[j*nk + i] = x[kept[j]];
            for (int q = 0; q < NM; q++) A[j*nk + i] -= B[q*N + kept[j]]*x[pivot[q]];
        }
    }
    for (int c = 0; c < k; c++) {
        for (int i = 0; i < N; i++) t[i*k + c] = 0.0;
        for (int r = 0; r < NM; r++)
            for (int q = 0; q < NM; q++) t[pivot[r]*k + c] -= E[r*NM + q]*h[q*k + c];
        for (int i = 0; i < N; i++) {
            x[i] = b[i*k + c];
            for (int j = 0; j < N; j++) x[i] -= M[i*N + j]*t[j*k + c];
        }
        for (int i = 0; i < nk; i++) {
            a[i*k + c] = x[kept[i]];
            for (int q = 0; q < NM; q++) a[i*k + c] -= B[q*N + kept[i]]*x[pivot[q]];
        }
    }
    const int bad = solve(nk, A, a, k);
    if (bad) return kept[bad - 1] + 1;
    for (int c = 0; c < k; c++) {
        double w[NM];
        for (int i = 0; i < nk; i++) {
            t[kept[i]*k + c] += a[i*k + c];
            for (int q = 0; q < NM; q++) t[pivot[q]*k + c] -= B[q*N + kept[i]]*a[i*k + c];
        }
        for (int r = 0; r < NM; r++) {
            w[r] = -b[pivot[r]*k + c];
            for (int j = 0; j < N; j++) w[r] += M[pivot[r]*N + j]*t[j*k + c];
        }
        for (int q = 0; q < NM; q++) {
            h[q*k + c] = 0.0;
            for (int r = 0; r < NM; r++) h[q*k + c] += E[r*NM + q]*w[r];
        }
        for (int i = 0; i < N; i++) b[i*k + c] = d[i]*t[i*k + c];
    }
    return 0;
}
"""
