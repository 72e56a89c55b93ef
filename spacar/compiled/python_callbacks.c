/* Questions to Python (spacar/compiled/python_callbacks.py).

   The engine is not built against any version of Python: it is given the addresses of functions of Python's stable C interface, and
   of a few types. The user function of a single case is called from here: an answer with the form of an earlier one, almost every one
   of a run, is taken here; Python reads the others.
   Nothing that is raised passes through C: it is handed to `keep`, and the evaluation ends. */
enum { ASK_MOTION, ASK_STRESS, ASK_STRAIN, ASK_CONVECTIVE, ASK_INERTIA, ASK_OUTPUT }; /* as in user_callbacks.py */

typedef struct {
    int (*ensure)(void);
    void (*release)(int);
    void *(*whole)(long), *(*number)(double);
    double (*as_double)(void *);
    void *(*call)(void *, ...);
    int (*is_true)(void *);
    void *(*type)(void *);
    ptrdiff_t (*list_size)(void *), (*tuple_size)(void *);
    void *(*list_item)(void *, ptrdiff_t), *(*tuple_item)(void *, ptrdiff_t); /* borrowed */
    void (*drop)(void *);                                                    /* a reference; nothing for NULL */
    void *(*occurred)(void);
    int (*matches)(void *);
    void (*clear)(void);
    void (*fetch)(void **, void **, void **), (*normalize)(void **, void **, void **);
    int (*set_traceback)(void *, void *);
    void *real_type, *numpy_real, *whole_type, *list_type, *tuple_type, *exception;
} Python;

/* Rows of an answer: addresses of the objects that are their two leading numbers, and their places in e or x. */
typedef struct { int64_t first, second, place; } Row;

typedef struct {
    const Python *python;
    double *sigma, *force;      /* where the answers of a user function that C calls are written */
    int n_sigma;                /* rows of stresses as those of an earlier answer; negative: none are known */
    void *function, *told[8];   /* the user function of a single case, or NULL; what it is called with, behind the time */
    int (*back)(int what, int batch, double t); /* where there is no `python`: callback of ctypes, not 0 when C has to stop */
    void *answer, *keep, *read; /* called with the same, true when C has to stop; with what was raised; with the time and an answer */
    const Row *rows;            /* of stresses and behind them of forces */
    double t;                   /* of the last question to `function` */
    int n_force;
    int within, stopped;        /* whether `function` itself has raised; set by what is no Exception: nobody is asked any more */
} PythonCallbacks;

/* Types live as long as the object. */
static void *type_of(const Python *py, void *object)
{
    void *type = py->type(object);
    py->drop(type);
    return type;
}

/* Write the values of n rows of the known form, and give their sum; NAN when Python has to read them: some may have been written. */
static double take_rows(const Python *py, void *rows, const Row *known, int n, double *values)
{
    if (type_of(py, rows) != py->list_type || py->list_size(rows) != n) return NAN;
    double total = 0.0;
    for (int k = 0; k < n; k++) {
        void *row = py->list_item(rows, k), *type = type_of(py, row);
        const int is_tuple = type == py->tuple_type;
        if (!is_tuple && type != py->list_type) return NAN;
        void *(*const item)(void *, ptrdiff_t) = is_tuple ? py->tuple_item : py->list_item;
        if ((is_tuple ? py->tuple_size : py->list_size)(row) != 3) return NAN;
        if ((intptr_t)item(row, 0) != known[k].first || (intptr_t)item(row, 1) != known[k].second) return NAN;
        void *value = item(row, 2), *kind = type_of(py, value);
        if (kind != py->real_type && kind != py->numpy_real && kind != py->whole_type) return NAN;
        const double number = py->as_double(value);
        if (number == -1.0 && py->occurred()) { py->clear(); return NAN; } /* too large */
        values[known[k].place] = number;
        total += number;
    }
    return total;
}

/* Whether time, stresses, forces were taken. */
static int is_taken(const PythonCallbacks *a, void *given)
{
    const Python *py = a->python;
    if (a->n_sigma < 0 || type_of(py, given) != py->tuple_type || py->tuple_size(given) != 3) return 0;
    return isfinite(take_rows(py, py->tuple_item(given, 1), a->rows, a->n_sigma, a->sigma)
                    + take_rows(py, py->tuple_item(given, 2), a->rows + a->n_sigma, a->n_force, a->force));
}

/* Hand what was raised to Python, with its traceback. */
static void keep_raised(PythonCallbacks *a)
{
    const Python *py = a->python;
    void *type, *value, *traceback;
    if (!py->matches(py->exception)) a->stopped = 1;
    py->fetch(&type, &value, &traceback);
    py->normalize(&type, &value, &traceback);
    if (value && traceback) py->set_traceback(value, traceback);
    void *done = py->call(a->keep, value, NULL);
    if (!done) py->clear();
    py->drop(done);
    py->drop(type);
    py->drop(value);
    py->drop(traceback);
}

/* OK, or NOT_ANSWERED: Python keeps an error, or wants to look. `batch` of a question about elements. */
static int ask(PythonCallbacks *a, int what, int batch, double t)
{
    if (a->stopped) return NOT_ANSWERED;
    const Python *py = a->python;
    if (!py) return a->back(what, batch, t) ? NOT_ANSWERED : OK;
    const int held = py->ensure();
    void *of[] = {py->whole(what), py->whole(batch), py->number(t)};
    void *answer = of[0] && of[1] && of[2] ? py->call(a->answer, of[0], of[1], of[2], NULL) : NULL;
    const int stops = answer ? py->is_true(answer) : -1;
    a->within = 0;
    if (stops < 0) keep_raised(a);
    py->drop(answer);
    for (int k = 0; k < 3; k++) py->drop(of[k]);
    py->release(held);
    return stops ? NOT_ANSWERED : OK;
}

/* The user function: OK, or NOT_ANSWERED as above. Values are zeros before. */
static int ask_stresses(PythonCallbacks *a, double t)
{
    if (!a->function) return ask(a, ASK_STRESS, 0, t);
    if (a->stopped) return NOT_ANSWERED;
    const Python *py = a->python;
    void *const *w = a->told;
    const int held = py->ensure();
    void *time = py->number(t), *done = NULL;
    void *given = time ? py->call(a->function, time, w[0], w[1], w[2], w[3], w[4], w[5], w[6], w[7], NULL) : NULL;
    a->t = t;
    a->within = !given;
    int answered = given && is_taken(a, given);
    if (given && !answered) answered = (done = py->call(a->read, time, given, NULL)) != NULL;
    if (!answered) keep_raised(a);
    py->drop(done);
    py->drop(given);
    py->drop(time);
    py->release(held);
    return answered ? OK : NOT_ANSWERED;
}
