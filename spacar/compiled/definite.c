/* The proof that a state at rest is stable: spacar/stationary/definite.py, which gives the constants, in C. */

/* The pattern of the stiffness and its order. OK or NO_MEMORY. */
static int definite_pattern(const Equilibrium *q, Own *w)
{
    size_t squares = 0;
    for (int k = 0; k < q->n_groups; k++) squares += w->pieces[k].square;
    Graph graph = {0};
    int *rows = taken(&graph.memory, 2 * squares + q->nf + 1, sizeof(int)), *columns = rows + squares,
        *rank = columns + squares, count = 0;
    for (int k = 0; rows && k < q->n_groups; k++) pairs_of(w, &q->groups[k], rows, columns, &count);
    int status = rows ? graph_of(&graph, (int)q->nf, rows, columns, count) : NO_MEMORY;
    if (status == OK) status = band_order(&graph, rank);
    if (status == OK) {
        const int b = w->definite_b = band_width(&graph, rank);
        w->definite_known = 1;
        w->definite_band = cleared(&w->memory, (size_t)q->nf * (b + 1), sizeof(double));
        w->definite_size = cleared(&w->memory, q->nf, sizeof(double));
        if (!w->definite_band || !w->definite_size) status = NO_MEMORY;
        count = 0;
        for (int k = 0; k < q->n_groups; k++) {
            for (int i = 0; i < w->pieces[k].square; i++, count++) { /* the lower half */
                const int r = rows[count] < 0 ? -1 : rank[rows[count]], c = columns[count] < 0 ? -1
                    : rank[columns[count]];
                w->pieces[k].definite_row[i] = r < c || c < 0 ? -1 : r;
                w->pieces[k].definite_column[i] = c;
            }
        }
    }
    give_back(&graph.memory);
    return status;
}

/* Is it proved that the tangent stiffness at x, sigma has no negative eigenvalue? See definite.py. */
static int spacar_equilibrium_definite(Equilibrium *q)
{
    Own *w = q->own;
    if (!w->definite_known && definite_pattern(q, w) != OK) w->definite_known = -1;
    if (w->definite_known < 0) return 0;
    rest_loads(q, w);
    rest_elements(q, w, q->x);
    if (!rest_blocks(q, w, q->sigma)) return 0;
    const int n = (int)q->nf, b = w->definite_b;
    double size = w->elastic, most = 1.0;
    for (int k = 0; k < q->n_groups; k++) { /* what is left of gravity and stresses in H */
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        const int nxe = g->elements->nxe, m = g->elements->n, s = nxe * nxe * m;
        for (int i = 0; i < s; i++) p->H[i] = (g->curved ? p->H[i] : 0.0) + (g->heavy ? p->by_x[i] : 0.0);
        if (!g->curved && !g->heavy) continue;
        for (int a = 0; a < nxe; a++) for (int c = 0; c < nxe; c++) for (int i = 0; i < m; i++) {
            const int64_t x = g->x[a * m + i], y = g->x[c * m + i];
            if (w->place[x] >= 0 && w->place[y] >= 0)
                size = larger(size, p->H[(a * nxe + c) * m + i] * q->scale[x] * q->scale[y]);
        }
    }
    if (!(size > 0.0 && size < INFINITY)) return 0;
    memset(w->definite_size, 0, sizeof(double) * n);
    memset(w->definite_band, 0, sizeof(double) * n * ((size_t)b + 1));
    /* V' (S + springs) V of every element; the sum of the sizes on the diagonal */
    for (int k = 0; k < q->n_groups; k++) {
        const Group *g = &q->groups[k];
        const Piece *p = &w->pieces[k];
        const int nxe = g->elements->nxe, nee = g->elements->nee, m = g->elements->n;
        double *P = p->by_x + (size_t)nxe * nxe * m;
        memset(P, 0, sizeof(double) * nxe * nxe * m);
        for (int r = 0; r < nee; r++) for (int c = 0; c < nee; c++) {
            double *restrict stiffness = p->sigma, most_stiff = 0.0; /* of all elements */
            for (int i = 0; i < m; i++) {
                const int64_t e = g->e[r * m + i], f = g->e[c * m + i];
                const int given = prescribes(q, e), both = !given && !prescribes(q, f) && w->coupled[e] != 0.0
                    && w->coupled[f] != 0.0;
                stiffness[i] = both && g->S ? g->S[(r * nee + c) * m + i] : 0.0;
                if (r == c && given) stiffness[i] = q->weight * size / (q->e_scale[e] * q->e_scale[e]);
                most_stiff = larger(most_stiff, stiffness[i]);
            }
            if (most_stiff == 0.0) continue;
            for (int a = 0; a < nxe; a++) for (int d = 0; d < nxe; d++) {
                const double *left = g->V + (r * nxe + a) * m, *right = g->V + (c * nxe + d) * m;
                double *restrict to = P + (a * nxe + d) * m;
                for (int i = 0; i < m; i++) to[i] += stiffness[i] * left[i] * right[i];
            }
        }
        for (int j = 0; j < p->square; j++) {
            const int row = p->definite_row[j];
            if (row >= 0 && row == p->definite_column[j]) w->definite_size[row] += fabs(P[j]) + fabs(p->H[j]);
        }
    }
    for (int i = 0; i < n; i++) {
        if (!(w->definite_size[i] > 0.0)) return 0;
        w->definite_size[i] = 1.0 / sqrt(w->definite_size[i]);
    }
    for (int k = 0; k < q->n_groups; k++) {
        const Piece *p = &w->pieces[k];
        const double *P = p->by_x + p->square;
        for (int j = 0; j < p->square; j++) {
            const int row = p->definite_row[j], column = p->definite_column[j];
            if (row < 0) continue;
            const double scale = w->definite_size[column] * w->definite_size[row];
            w->definite_band[(size_t)column * b + row] += scale * (p->H[j] + P[j]);
            most = larger(larger(most, scale * p->H[j]), scale * P[j]);
        }
    }
    const double less = n * DBL_EPSILON * q->safe * most;
    for (int i = 0; i < n; i++) w->definite_band[(size_t)i * (b + 1)] -= less;
    return band_positive(w->definite_band, n, b);
}
