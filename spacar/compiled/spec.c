/* What a model is made of, from the arrays of spacar/compiled/compiled_model.py. */

static const int *next_whole(const int **at, int n) { *at += n; return *at - n; }
static real *next_numbers(real **at, size_t n) { *at += n; return *at - n; }
static const double *next_sizes(real **at, size_t n)
{
    const double *first = (const double *)*at;
    *at = (real *)(first + n);
    return first;
}

/* Columns of a list (rows, n) one after the other; the place behind them. */
static int *turned(int *to, const int *list, int rows, int n)
{
    for (int i = 0; i < n; i++) for (int j = 0; j < rows; j++) *to++ = list[j * n + i];
    return to;
}

/* The parameters of the elements, those of an element together, from the numbers of `read_spec`. */
static void take_parameters(Model *m)
{
    const real *p = m->given_parameters;
    real *parameter = m->parameters;
    for (int b = 0; b < m->s.n_batches; b++) {
        const Batch *k = &m->s.batches[b];
        for (int i = 0; i < k->n; i++) for (int j = 0; j < k->np; j++) *parameter++ = p[j * k->n + i];
        p += k->n * k->np;
    }
}

/* The spec from its two arrays, which must stay: whole numbers (counts in the order of Spec, those of each batch in
   the order of Batch, lists) and numbers of the cases (lists), the sizes last. Those of batches have the elements
   last. `foreign`: of each batch, or NULL when there are none. OK or NO_MEMORY. */
static int read_spec(Model *m, const int *whole, real *numbers, const Foreign *const *foreign)
{
    Spec *s = &m->s;
    const int counts = (int)(offsetof(Spec, max_iterations) / sizeof(int)) + 1,
        of_batch = (int)(offsetof(Batch, inertia) / sizeof(int)) + 1;
    memcpy(s, next_whole(&whole, counts), counts * sizeof(int));
    Batch *batches = cleared(&m->memory, s->n_batches, sizeof(Batch));
    const int n_calculable = s->x_input - s->n_fixed_x;
    s->n_free = n_calculable + s->n_x_dynamic + s->n_x_kinematic;
    int *free_x = cleared(&m->memory, s->n_free, sizeof(int));
    s->batches = batches;
    s->free = free_x;
    if (!batches || !free_x) return NO_MEMORY;
    for (int i = 0; i < n_calculable; i++) *free_x++ = s->n_fixed_x + i;
    for (int i = 0; i < s->n_x_dynamic; i++) *free_x++ = s->x_dynamic + i;
    for (int i = 0; i < s->n_x_kinematic; i++) *free_x++ = s->x_kinematic + i;
    for (int b = 0; b < s->n_batches; b++) {
        memcpy(&batches[b], next_whole(&whole, of_batch), of_batch * sizeof(int));
        if (batches[b].kind < 0) batches[b].foreign = foreign[b];
    }
    s->x_motion = next_numbers(&numbers, 3 * s->n_x_input);
    s->e_motion = next_numbers(&numbers, 3 * s->n_e_input);
    s->force = next_numbers(&numbers, s->nx);
    s->preload = next_numbers(&numbers, s->ne);
    s->x0 = next_numbers(&numbers, s->nx);
    s->field = next_numbers(&numbers, s->nx);
    s->position = next_whole(&whole, s->n_position);
    s->translation = next_whole(&whole, s->nx);
    const struct { int n; const int **row, **column; const real **value; } entries[] = {
        { s->n_constant, &s->constant_row, &s->constant_column, &s->constant_mass },
        { s->n_stiffness, &s->s_rows, &s->s_columns, &s->s_values },
        { s->n_damping, &s->d_rows, &s->d_columns, &s->d_values },
        { s->n_moments, &s->moment_rows, &s->moment_columns, &s->moments },
        { s->n_coupled, &s->coupled_rows, &s->coupled_columns, &s->coupled },
    };
    for (int k = 0; k < 5; k++) {
        *entries[k].row = next_whole(&whole, entries[k].n);
        *entries[k].column = next_whole(&whole, entries[k].n);
        *entries[k].value = next_numbers(&numbers, entries[k].n);
    }
    int n_places = 0, n_parameters = 0;
    for (int b = 0; b < s->n_batches; b++) {
        n_places += batches[b].n * (batches[b].nxe + batches[b].nee);
        n_parameters += batches[b].n * batches[b].np;
    }
    int *place = m->places = cleared(&m->memory, n_places, sizeof(int));
    real *parameter = m->parameters = cleared(&m->memory, n_parameters, sizeof(real));
    if (!place || !parameter) return NO_MEMORY;
    m->given_parameters = next_numbers(&numbers, n_parameters);
    for (int b = 0; b < s->n_batches; b++) {
        Batch *k = &batches[b];
        k->x = place;
        place = turned(place, next_whole(&whole, k->n * k->nxe), k->nxe, k->n);
        k->e = place;
        place = turned(place, next_whole(&whole, k->n * k->nee), k->nee, k->n);
        k->p = parameter;
        parameter += k->n * k->np;
    }
    s->scale = next_sizes(&numbers, s->nx);
    s->e_scale = next_sizes(&numbers, s->ne);
    s->criteria = (const void *)next_sizes(&numbers, 3);
    take_parameters(m);
    return OK;
}
