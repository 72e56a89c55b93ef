/* Memory of one owner: cut piece by piece from blocks, given back as a whole. Lists of entries of matrices in it. */
enum { LINE = 64, BLOCK = 1 << 15 };

typedef struct Block { struct Block *before; } Block;
typedef struct { Block *last; char *next; size_t left; } Memory; /* zeros: nothing yet */

/* Room that is written before it is read, at the start of a line of the cache: a vector is one line. NULL when there
   is no memory. */
static void *taken(Memory *of, size_t count, size_t size)
{
    const size_t bytes = (count * size + LINE - 1) / LINE * LINE;
    if (!of->last || bytes > of->left) {
        const size_t room = bytes > BLOCK ? bytes : BLOCK;
        Block *block = malloc(sizeof(Block) + LINE + room);
        if (!block) return NULL;
        block->before = of->last;
        of->last = block;
        of->next = (char *)(((uintptr_t)(block + 1) + LINE - 1) / LINE * LINE);
        of->left = room;
    }
    void *piece = of->next;
    of->next += bytes;
    of->left -= bytes;
    return piece;
}

/* The same, zeros. */
static void *cleared(Memory *of, size_t count, size_t size)
{
    void *piece = taken(of, count, size);
    return piece ? memset(piece, 0, count * size) : NULL;
}

static void give_back(Memory *of)
{
    while (of->last) {
        Block *before = of->last->before;
        free(of->last);
        of->last = before;
    }
    *of = (Memory){0};
}

typedef struct { int n, *row, *column, *source; } Entries; /* (n) each; `source` is a place in `values` */

static int entries_begin(Memory *memory, Entries *list, int capacity)
{
    list->n = 0;
    list->row = taken(memory, capacity, sizeof(int));
    list->column = taken(memory, capacity, sizeof(int));
    list->source = taken(memory, capacity, sizeof(int));
    return list->row && list->column && list->source ? OK : NO_MEMORY;
}

static void add(Entries *list, int row, int column, int source)
{
    list->row[list->n] = row;
    list->column[list->n] = column;
    list->source[list->n++] = source;
}
