/* exover_form.h - a part of exover.c, which includes it unless EXOVER_SHAPE is defined: tables of any shape are looked at
 * once, since nothing is known of them but what they say themselves. docs/runtime.md has the layout. */

static const uint8_t FIELDS[EXOVER_SECTIONS] = {4, 5, 26, 7, 3, 7, 2, 3, 3, 16, 4, 3, 2, 4, 4, 2, 1, 2, 2, 1};

/* What a field may be, in one byte: of what it is the index, and how. */
#define AT(what) (what)
#define OR_NONE(what) (32 | (what))
#define OR_ALWAYS(what) (64 | (what))
#define FROM(what) (96 | (what))       /* an index or the end */
#define TO(what) (128 | (what))        /* likewise, and not less than the field before */
#define IF_REAL(fields) (160 | (fields)) /* of a real, an index of doubles; its type stands so many fields before */

/* cppcheck-suppress misra-c2012-8.9 ; it stands beside the macros that it is made of */
static const uint8_t SCHEMA[] = {
    ANY, ANY, OR_NONE(NODES), ANY,                                           /* nodes */
    ANY, FROM(LISTS), TO(LISTS), FROM(SUMS), TO(SUMS),                       /* entries */
    AT(NODES), NATURAL, NATURAL, NATURAL, AT(FLAG), NATURAL,                 /* requests */
    FROM(PARAMS), TO(PARAMS), TO(PARAMS), FROM(ORDERS), TO(ORDERS), FROM(FEATURES), TO(FEATURES), FROM(PASTS),
    TO(PASTS), FROM(AMOUNTS), TO(AMOUNTS), TO(AMOUNTS), FROM(EFFECTS), TO(EFFECTS), TO(EFFECTS), TO(EFFECTS),
    TO(EFFECTS), OR_NONE(ENTRIES), FROM(CONFLICTS), TO(CONFLICTS),
    AT(TYPE), IF_REAL(1), IF_REAL(2), FROM(REALS), TO(REALS), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* params */
    ANY, ANY, OR_NONE(ENTRIES),                                              /* orders */
    OR_ALWAYS(NODES), ANY, ANY, OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* features */
    OR_ALWAYS(NODES), OR_NONE(ENTRIES),                                      /* pasts */
    AT(STOCKS), NATURAL, OR_ALWAYS(NODES),                                   /* amounts */
    AT(FLAG), NATURAL, ANY,                                                  /* effects */
    AT(ROLE), AT(TYPE), IF_REAL(1), IF_REAL(2), IF_REAL(3), AT(FLAG), IF_REAL(5), FROM(REALS), TO(REALS),
    OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(VARIABLES), FROM(LISTS), TO(LISTS), FROM(ORDERS), TO(ORDERS),
    AT(VARIABLES), OR_NONE(NODES), FROM(LISTS), TO(LISTS),                   /* latches */
    NATURAL, NATURAL, OR_NONE(ENTRIES),                                      /* stocks */
    OR_NONE(NODES), NATURAL,                                                 /* rules */
    OR_NONE(NODES), AT(REQUESTS), FROM(LISTS), NATURAL,                      /* launches */
    NATURAL, NATURAL, NATURAL, NATURAL,                                      /* limits */
    AT(BLOCKS), ANY,                                                         /* conflicts */
    AT(DENIALS),                                                             /* reasons */
    OR_NONE(NODES), NATURAL,                                                 /* invariants */
    AT(ENTRIES), ANY,                                                        /* sums */
    ANY                                                                      /* lists */
};

static bool below(exover_int index, exover_int count)
{
    return index >= 0 && index < count;
}

/* Take the shape of the words from the header; false if the numbers of records do not give the sizes of the arrays. */
static bool counts_fit(exover *c, const exover_tables *tables)
{
    const uint32_t checks = tables->head[EXOVER_HEAD_CHECKS];
    uint32_t start = 0, records = 0;
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++) {
        uint32_t count = tables->head[EXOVER_HEAD_COUNTS + section];
        if (count > INT32_MAX / 32 || count > (tables->word_count - start) / FIELDS[section]) {
            return false;
        }
        c->shape[EXOVER_STARTS + section] = start;
        c->shape[EXOVER_COUNTS + section] = count;
        c->shape[EXOVER_CHECKS + section] = records;
        start += count * FIELDS[section];
        records += count;
    }
    c->shape[EXOVER_STARTS + EXOVER_SECTIONS] = start;
    c->shape[EXOVER_CHECKS + EXOVER_SECTIONS] = records;
    for (unsigned section = 0; section <= EXOVER_SECTIONS; section++) {
        c->shape[EXOVER_CHECKS + section] = checks == 0u ? 0u : start + c->shape[EXOVER_CHECKS + section];
    }
    c->shape[EXOVER_REALS] = tables->head[EXOVER_HEAD_REALS];
    c->shape[EXOVER_CHECKSUM] = tables->head[EXOVER_HEAD_CHECKSUM];
    c->shape[EXOVER_WORDS] = start + checks;
    return (checks == 0u || checks == records + c->shape[EXOVER_REALS]) && start + checks == tables->word_count
           && tables->word_count <= INT32_MAX / EXOVER_WIDTH && c->shape[EXOVER_REALS] == tables->real_count
           && tables->real_count <= INT32_MAX / 32;
}

static bool sections_fit(const exover *c)
{
    for (unsigned section = 0; section <= REALS; section++) {
        if (!USES(section) && COUNT(section) != 0) {
            return false;
        }
    }
    return USES(CHECKS) || SHAPE(EXOVER_WORDS) == SHAPE(EXOVER_STARTS + EXOVER_SECTIONS);
}

/* Whether a field is what its byte of the schema says. */
static bool field_holds(const exover *c, const exover_word *word, unsigned schema)
{
    const exover_int many[] = {2, 4, 3, 3, (COUNT(REQUESTS) + 15) / 16}; /* flags, types, roles, denials, blocks */
    unsigned what = schema & 31u, how = schema & 224u;
    if (how == IF_REAL(0)) {
        return word[-(int)what] != REAL || below(*word, COUNT(REALS));
    }
    if (what >= NATURAL) {
        return what == ANY || *word >= 0;
    }
    exover_int count = what <= REALS ? COUNT(what) : many[what - FLAG];
    exover_int least = how == OR_NONE(0) ? -1 : how == OR_ALWAYS(0) ? -2 : how == TO(0) ? word[-1] : 0;
    return *word >= least && *word < count + (how == FROM(0) || how == TO(0));
}

static bool fields_hold(const exover *c)
{
    const exover_word *word = c->words;
    unsigned schema = 0;
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++) {
        for (exover_int record = 0; record < COUNT(section); record++) {
            for (unsigned field = 0; field < FIELDS[section]; field++, word++) {
                if (!field_holds(c, word, SCHEMA[schema + field])) {
                    return false;
                }
            }
        }
        schema += FIELDS[section];
    }
    return true;
}

/* Whether every check word is that of its record. */
static bool checks_hold(exover *c)
{
    for (unsigned section = 0; section < EXOVER_SECTIONS; section++) {
        for (exover_int i = 0; i < COUNT(section); i++) {
            (void)holds(c, FIRST(section), CHECK(section), FIELDS[section], i);
        }
    }
    for (exover_int i = 0; i < COUNT(REALS); i++) {
        (void)real_at(c, i);
    }
    return c->fault == EXOVER_READY;
}

/* Every child after its parent, so that every walk ends; every action one that there is, with a target that there is. */
static bool nodes_hold(exover *c)
{
    exover_int slots = (exover_int)(c->shape[EXOVER_HELD] - c->shape[EXOVER_PHASES]) - COUNT(REQUESTS);
    for (exover_int i = 0; i < COUNT(NODES); i++) {
        const exover_node *node = &ALL(node, NODES)[i];
        exover_int high = node->high, least = 0, most = COUNT(REQUESTS) - 1;
        if (node->low != NONE && node->low <= i) {
            return false;
        }
        if (node->code >= 0) {
            if (node->code >= COUNT(ENTRIES) || high < NONE || high >= COUNT(NODES) || (high >= 0 && high <= i)) {
                return false;
            }
            continue;
        }
        if (node->code == -KILL) {
            least = -slots;
        } else if (node->code != -DISMISS) {
            most = high; /* no target */
        } else {
            /* a waiting place of a request */
        }
        if ((!USES(WAITS) && node->code <= -WAIT && node->code >= -SETTLE) || (!USES(KILLS) && node->code == -KILL)) {
            return false;
        }
        if (node->code < -AGREE || node->bound < 0 || high < least || high > most
            || (node->code >= -CLEAR && node->bound >= COUNT(REASONS))) {
            return false;
        }
    }
    return true;
}

static bool sums_hold(exover *c)
{
    for (exover_int i = 0; i < COUNT(SUMS); i++) {
        const exover_entry *sum = &ALL(entry, ENTRIES)[ALL(sum, SUMS)[i].entry];
        if (sum->sums != sum->sums_end) {
            return false;
        }
    }
    return true;
}

/* Whether the words `from .. to` of the lists are indices of records of a section. */
static bool list_holds(const exover *c, exover_int from, exover_int to, unsigned section)
{
    for (exover_int i = from; i < to; i++) {
        if (!below(LIST[i], COUNT(section))) {
            return false;
        }
    }
    return true;
}

/* Whether both sides of every comparison are there: one of so many parameters, or a poster whose value is kept. */
static bool orders_hold(exover *c, exover_int from, exover_int to, exover_int params)
{
    for (; USES(ORDERS) && from < to; from++) {
        const exover_order *order = &ALL(order, ORDERS)[from];
        for (int side = 0; side < 2; side++) {
            exover_int k = side ? order->right : order->left;
            if (k >= params || -1 - k >= COUNT(VARIABLES) || (k < 0 && ALL(variable, VARIABLES)[-1 - k].raw < 0)) {
                return false;
            }
        }
    }
    return true;
}

/* Whether slots and arguments of the requests stand one after another; how many there are goes into the shape. */
static bool requests_hold(exover *c)
{
    exover_int slots = 0;
    uint64_t values = 0, most = 0;
    for (exover_int i = 0; i < COUNT(REQUESTS); i++) {
        const exover_request *row = &ALL(request, REQUESTS)[i];
        if ((!USES(LASTS) && row->last != NONE) || row->slots != slots || row->instances < 1 || row->instances > MOST_SLOTS - slots
            || (uint64_t)row->values != values
            || !orders_hold(c, row->orders, row->orders_end, row->params_end - row->params)) {
            return false;
        }
        for (exover_int k = row->features; k < row->features_end; k++) {
            const exover_feature *feature = &ALL(feature, FEATURES)[k];
            if (feature->slot < NONE || feature->slot >= row->instances || feature->weight >= params_of(row)) {
                return false;
            }
        }
        slots += row->instances;
        values += (uint64_t)params_of(row) * ((uint64_t)row->instances + 1);
        most = (uint64_t)params_of(row) > most ? (uint64_t)params_of(row) : most;
        if (values > INT32_MAX / 32) {
            return false;
        }
    }
    c->shape[EXOVER_PHASES] = (uint32_t)COUNT(ENTRIES);
    c->shape[EXOVER_HELD] = (uint32_t)(COUNT(ENTRIES) + slots + COUNT(REQUESTS));
    c->shape[EXOVER_KEPT] = (uint32_t)values;
    c->shape[EXOVER_SCRATCH] = COUNT(LAUNCHES) == 0 ? 0 : (uint32_t)most;
    return true;
}

/* Whether the records that refer to lists or to variables of some type do so rightly. */
static bool records_hold(exover *c)
{
    for (exover_int i = 0; i < COUNT(ENTRIES); i++) {
        if (!list_holds(c, ALL(entry, ENTRIES)[i].rules, ALL(entry, ENTRIES)[i].rules_end, RULES)) {
            return false;
        }
    }
    for (exover_int i = 0; USES(VARIABLES) && i < COUNT(VARIABLES); i++) {
        const exover_variable *row = &ALL(variable, VARIABLES)[i];
        if (!list_holds(c, row->refresh, row->refresh_end, REQUESTS) || !orders_hold(c, row->orders, row->orders_end, 0)
            || (row->raw >= 0 && row->domain.type != REAL) || (row->role != POSTER && row->domain.type == REAL)) {
            return false;
        }
    }
    for (exover_int i = 0; USES(LATCHES) && i < COUNT(LATCHES); i++) {
        const exover_latch *row = &ALL(latch, LATCHES)[i];
        if (!list_holds(c, row->resets, row->resets_end, REQUESTS)
            || ALL(variable, VARIABLES)[row->variable].role == POSTER) {
            return false;
        }
    }
    for (exover_int i = 0; USES(EFFECTS) && i < COUNT(EFFECTS); i++) {
        const exover_effect *row = &ALL(effect, EFFECTS)[i];
        if (row->target >= COUNT(row->kind == SET ? VARIABLES : REQUESTS)
            || (row->kind == SET && ALL(variable, VARIABLES)[row->target].role == POSTER)) {
            return false;
        }
    }
    for (exover_int i = 0; USES(LAUNCHES) && i < COUNT(LAUNCHES); i++) {
        const exover_launch_rule *row = &ALL(launch_rule, LAUNCHES)[i];
        const exover_request *request = &ALL(request, REQUESTS)[row->request];
        if (row->args > COUNT(LISTS) - params_of(request)) {
            return false;
        }
        for (exover_int k = 0; k < params_of(request); k++) {
            if (ALL(param, PARAMS)[request->params + k].domain.type == REAL && !below(LIST[row->args + k], COUNT(REALS))) {
                return false;
            }
        }
    }
    return true;
}

static bool limits_hold(exover *c)
{
    const exover_limits *limits = ALL(limits, LIMITS);
    uint32_t slots = c->shape[EXOVER_HELD] - c->shape[EXOVER_PHASES];
    return COUNT(LIMITS) == 1 && limits->passes >= 1 && limits->violations <= COUNT(RULES)
           && limits->passes / 4 <= (exover_int)slots + COUNT(LAUNCHES) && limits->actions <= COUNT(NODES);
}

static uint32_t blocks(exover_int count, exover_int bits)
{
    const exover_int found = (count + bits - 1) / bits;
    return (uint32_t)found;
}

/* Find the rest of the shape. */
static void lay_out(exover *c)
{
    uint32_t *shape = c->shape, raws = 0, slots = shape[EXOVER_HELD] - shape[EXOVER_PHASES] - (uint32_t)COUNT(REQUESTS);
    const exover_limits *limits = ALL(limits, LIMITS);
    for (exover_int i = 0; USES(VARIABLES) && i < COUNT(VARIABLES); i++) {
        exover_int raw = ALL(variable, VARIABLES)[i].raw;
        raws = raw >= 0 && (uint32_t)raw >= raws ? (uint32_t)raw + 1 : raws;
    }
    shape[EXOVER_ACTIVE] = shape[EXOVER_HELD] + (uint32_t)COUNT(REQUESTS);
    shape[EXOVER_DIRTY] = shape[EXOVER_ACTIVE] + blocks(COUNT(REQUESTS), 16);
    shape[EXOVER_BROKEN] = shape[EXOVER_DIRTY] + blocks(COUNT(RULES), 32);
    shape[EXOVER_TAKEN] = shape[EXOVER_BROKEN] + blocks(COUNT(RULES), 32);
    shape[EXOVER_ORIGINS] = shape[EXOVER_TAKEN] + blocks(COUNT(REQUESTS), 32);
    shape[EXOVER_REFUSED] = shape[EXOVER_ORIGINS] + (COUNT(LAUNCHES) == 0 ? 0u : (uint32_t)COUNT(REQUESTS));
    shape[EXOVER_MARKS] = shape[EXOVER_REFUSED] + (uint32_t)COUNT(LAUNCHES);
    shape[EXOVER_CELLS] = shape[EXOVER_MARKS] + blocks(COUNT(LAUNCHES) + COUNT(REQUESTS), 32);
    shape[EXOVER_VALUES] = shape[EXOVER_KEPT] + raws;
    shape[EXOVER_CAPACITY] = 2 * slots + (uint32_t)(COUNT(REQUESTS) + 3 * COUNT(LAUNCHES) + limits->violations) + 4;
    shape[EXOVER_STEPS] = (uint32_t)limits->actions;
}

/* Whether tables whose checksum is right can be used, whoever made them. */
static exover_status form_of(exover *c)
{
    if (!fields_hold(c) || !requests_hold(c) || !records_hold(c)) {
        return EXOVER_BAD_INDEX;
    }
    if (!nodes_hold(c)) {
        return EXOVER_BAD_NODE;
    }
    if (!sums_hold(c)) {
        return EXOVER_BAD_SUM;
    }
    if (!limits_hold(c)) {
        return EXOVER_BAD_LIMITS;
    }
    if (!checks_hold(c)) {
        return EXOVER_BAD_CHECKSUM;
    }
    lay_out(c);
    return EXOVER_READY;
}
