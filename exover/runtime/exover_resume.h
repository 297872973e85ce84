/* exover_resume.h - a part of exover.c, which includes it at its end unless EXOVER_NO_RESUME is defined: the state of a
 * checker goes out in a record, and comes back after it was held against the tables. docs/runtime.md has the layouts. */

enum { RECORD_MAGIC = 0x524f5845, MAP_MAGIC = 0x4d4f5845 }; /* "EXOR", "EXOM" */
enum { RECORD_VERSION = 1, RECORD_HEAD = 56, MAP_HEAD = 100 };
enum { AT_VERSION = 4, AT_CHECKSUM = 8, AT_LENGTH = 12, AT_TABLES = 16, AT_STEP = 52, AT_IDLE = 88 };
enum { TABLES_BYTES = 36 }; /* the sha256 of a spec and the checksum of its tables */

/* Numbers on their way: into a record, or out of one, or out of that of other tables by a map. */
typedef struct transfer {
    unsigned char *out;
    const unsigned char *in, *map;
    uint32_t room, count; /* of numbers */
    uint32_t at;
    exover_status wrong;
} transfer;

/* Volatile, since compilers make a call of the C library of a plain loop. */
static void copy(void *to, const void *from, size_t size)
{
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    volatile unsigned char *bytes = (volatile unsigned char *)to;
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    const unsigned char *source = (const unsigned char *)from;
    for (size_t i = 0; i < size; i++) {
        bytes[i] = source[i];
    }
}

static uint64_t get(const unsigned char *bytes, unsigned size)
{
    uint64_t number = 0;
    for (unsigned i = size; i > 0u; i--) {
        number = number << 8 | bytes[i - 1u];
    }
    return number;
}

static void put_bytes(unsigned char *bytes, unsigned size, uint64_t number)
{
    uint64_t left = number;
    for (unsigned i = 0; i < size; i++) {
        bytes[i] = (unsigned char)left;
        left >>= 8;
    }
}

/* The checksum of a record or map, its own four bytes taken as 0. */
static uint32_t sum_of(const unsigned char *bytes, uint32_t length)
{
    uint32_t sum = 0xffffffffu;
    for (uint32_t i = 0; i < length; i++) {
        sum = add_byte(sum ^ (i - (uint32_t)AT_CHECKSUM < 4u ? 0u : bytes[i]));
    }
    return ~sum;
}

static bool is_whole(const unsigned char *bytes, size_t size, uint32_t magic, uint32_t least)
{
    return bytes != NULL && size >= least && size <= UINT32_MAX && get(bytes, 4) == magic
           && get(&bytes[AT_VERSION], 4) == (uint64_t)RECORD_VERSION && get(&bytes[AT_LENGTH], 4) == size
           && get(&bytes[AT_CHECKSUM], 4) == sum_of(bytes, (uint32_t)size);
}

/* Whether these bytes name tables: by the sha256 of their spec and by their checksum. */
static bool name_tables(const unsigned char *bytes, const uint32_t *head)
{
    bool same = get(&bytes[TABLES_BYTES - 4], 4) == head[EXOVER_HEAD_CHECKSUM];
    for (unsigned i = 0; i < 8u; i++) {
        same = same && get(&bytes[4u * i], 4) == head[(unsigned)EXOVER_HEAD_DIGEST + i];
    }
    return same;
}

static bool same_bytes(const unsigned char *left, const unsigned char *right, unsigned size)
{
    bool same = true;
    for (unsigned i = 0; i < size; i++) {
        same = same && left[i] == right[i];
    }
    return same;
}

static bool reads(const transfer *t)
{
    return t->in != NULL;
}

static void refuse_number(transfer *t, exover_status why)
{
    if (t->wrong == EXOVER_READY) {
        t->wrong = why;
    }
}

/* What a map makes of the numbers of the other tables; what stands there if it says nothing of it. */
static uint64_t mapped(transfer *t, uint64_t now)
{
    const uint32_t idle = (uint32_t)get(&t->map[AT_IDLE], 4), numbers = (uint32_t)get(&t->map[AT_IDLE + 4], 4);
    if (t->at >= numbers) {
        refuse_number(t, EXOVER_BAD_MAP);
        return now;
    }
    const unsigned char *pair = &t->map[(uint32_t)MAP_HEAD + 4u * idle + 8u * t->at];
    const uint32_t source = (uint32_t)get(pair, 4), table = (uint32_t)get(&pair[4], 4);
    if (source == UINT32_MAX) {
        return now;
    }
    if (source >= t->count) {
        refuse_number(t, EXOVER_BAD_MAP);
        return now;
    }
    const uint64_t number = get(&t->in[(uint32_t)RECORD_HEAD + 8u * source], 8);
    if (table == UINT32_MAX) {
        return number;
    }
    const uint32_t lists = (uint32_t)get(&t->map[AT_IDLE + 8], 4);
    const unsigned char *list = &t->map[(uint32_t)MAP_HEAD + 4u * idle + 8u * numbers];
    const uint32_t length = table < lists ? (uint32_t)get(&list[4u * table], 4) : 0u;
    if (number >= length || length > lists - table - 1u) {
        refuse_number(t, EXOVER_BAD_VALUE);
        return now;
    }
    return get(&list[4u * (table + 1u + (uint32_t)number)], 4);
}

/* Let the next number pass; what stands there now if it stays. */
static uint64_t pass(transfer *t, uint64_t now)
{
    uint64_t number = now;
    if (t->map != NULL) {
        number = mapped(t, now);
    } else if (t->at >= t->room) {
        refuse_number(t, EXOVER_BAD_RECORD);
    } else if (reads(t)) {
        number = get(&t->in[(uint32_t)RECORD_HEAD + 8u * t->at], 8);
    } else {
        put_bytes(&t->out[(uint32_t)RECORD_HEAD + 8u * t->at], 8, now);
    }
    t->at++;
    return number;
}

/* Let the number of an entry pass, which lies within these bounds; 0 if nothing reads it. */
static void pass_entry(exover *c, transfer *t, exover_int entry, exover_int low, exover_int high)
{
    const exover_int now = entry < 0 ? 0 : (exover_int)CELL(VECTOR, entry)->now;
    const int64_t number = (int64_t)pass(t, (uint64_t)(int64_t)now);
    if (entry < 0 || !reads(t)) {
        return;
    }
    if (number < low || number > high) {
        refuse_number(t, EXOVER_BAD_VALUE);
    } else {
        put(c, entry, (exover_int)number);
    }
}

static void pass_variable(exover *c, transfer *t, exover_int variable)
{
    const exover_variable *row = RECORD(variable, VARIABLES, variable);
    if (USES(REALS) && row->domain.type == REAL && row->raw < 0) {
        pass_entry(c, t, row->gauge.rank, 0, 2 * minus(row->gauge.cuts_end, row->gauge.cuts));
    } else if (row->raw >= 0) {
        exover_value *raw = raw_of(c, variable);
        exover_value value = {0};
        value.bits = pass(t, raw == NULL ? 0u : raw->bits);
        if (reads(t) && !in_domain(c, &row->domain, value)) {
            refuse_number(t, EXOVER_BAD_VALUE);
        } else if (reads(t)) {
            take_reading(c, variable, value);
        } else {
            /* it is written */
        }
    } else {
        pass_entry(c, t, row->gauge.value, row->domain.low, row->domain.high);
    }
}

static void pass_args(exover *c, transfer *t, const exover_request *row, exover_int slot, bool held)
{
    exover_value *own = args_of(c, row, slot);
    for (exover_int k = 0; USES(PARAMS) && own != NULL && k < params_of(row); k++) {
        exover_value value = own[k];
        value.bits = pass(t, value.bits);
        if (reads(t)) {
            if (held && !in_domain(c, &RECORD(param, PARAMS, plus(row->params, k))->domain, value)) {
                refuse_number(t, EXOVER_BAD_VALUE);
            }
            keep(c, &own[k], value);
        }
    }
    c->loaded_args = NULL;
}

/* Let what a slot or waiting place holds pass. */
static void pass_slot(exover *c, transfer *t, exover_int request, const exover_request *row, exover_int slot)
{
    exover_cell *cell = CELL(PHASES, phase_at(request, row, slot));
    const bool is_place = slot == instances_of(row);
    const uint64_t number = pass(t, cell->now);
    const exover_uint phase = (exover_uint)(number & (SINCE - 1u));
    const bool fits_in = is_place ? phase == EMPTY || (USES(WAITS) && (phase == WAITING || phase == CLEARING)) : phase <= STOPPING;
    if (reads(t) && (!fits_in || number / SINCE > UINT32_MAX)) {
        refuse_number(t, EXOVER_BAD_VALUE);
        return;
    }
    pass_args(c, t, row, slot, phase != EMPTY);
    if (is_place && COUNT(LAUNCHES) != 0) {
        exover_cell *origin_cell = CELL(ORIGINS, request);
        const uint64_t reason = pass(t, origin_cell->now);
        if (reads(t) && reason > (uint64_t)COUNT(REASONS)) {
            refuse_number(t, EXOVER_BAD_VALUE);
        } else {
            set_cell(origin_cell, (exover_uint)reason);
        }
    }
    if (!reads(t) || t->wrong != EXOVER_READY) {
        return;
    }
    set_cell(cell, (exover_uint)number);
    if (phase != EMPTY && is_place) {
        c->agenda += PLACE;
        set_bit(BITS(TAKEN, request), request, true);
    } else if (phase != EMPTY) {
        occupy(c, request, 1);
    } else {
        /* nothing is held */
    }
    if (phase != EMPTY) {
        tally(c, row, slot, phase, 1);
    }
}

static void pass_request(exover *c, transfer *t, exover_int request)
{
    const exover_request *row = REQUEST(request);
    pass_entry(c, t, row->last, 0, EXOVER_INTERRUPTED);
    const exover_int end = USES(PASTS) ? END_OF(past, PASTS, row->pasts, row->pasts_end) : NONE;
    for (exover_int i = row->pasts; USES(PASTS) && i < end; i++) {
        pass_entry(c, t, ALL(past, PASTS)[i].entry, 0, 1);
    }
    for (exover_int slot = 0; slot <= instances_of(row); slot++) {
        pass_slot(c, t, request, row, slot);
    }
}

/* Let all that is remembered pass: readings and levels first, since what slots count for may depend on them. */
static void pass_all(exover *c, transfer *t)
{
    for (exover_int i = 0; USES(VARIABLES) && i < COUNT(VARIABLES); i++) {
        pass_variable(c, t, i);
    }
    for (exover_int i = 0; USES(STOCKS) && i < COUNT(STOCKS); i++) {
        const exover_stock *row = RECORD(stock, STOCKS, i);
        pass_entry(c, t, row->entry, 0, row->capacity);
    }
    for (exover_int i = 0; i < COUNT(REQUESTS); i++) {
        pass_request(c, t, i);
    }
    for (exover_int i = 0; USES(LAUNCHES) && i < COUNT(LAUNCHES); i++) {
        exover_cell *cell = CELL(REFUSED, i);
        const uint64_t refused = pass(t, cell->now);
        if (reads(t) && (refused % 2u != 0u || refused > 2u * (uint64_t)COUNT(REASONS))) {
            refuse_number(t, EXOVER_BAD_VALUE);
        } else {
            set_cell(cell, (exover_uint)refused);
        }
    }
    if (c->fault != EXOVER_READY) {
        refuse_number(t, c->fault);
    } else if (t->map == NULL && t->at != t->count) {
        refuse_number(t, EXOVER_BAD_RECORD);
    } else {
        /* all has passed */
    }
}

/* ---- what comes in is held against the rules ---- */

/* Whether requests are active together that a bit row keeps apart. */
static bool conflicts_broken(exover *c)
{
    bool broken = false;
    for (exover_int request = 0; request < COUNT(REQUESTS) && !broken; request++) {
        const exover_request *row = REQUEST(request);
        const exover_uint own = (exover_uint)1 << ((exover_uint)request & 15u);
        const exover_cell *active = &c->cells[SHAPE(EXOVER_ACTIVE)];
        const exover_int end = END_OF(conflict, CONFLICTS, row->conflicts, row->conflicts_end);
        for (exover_int i = row->conflicts; i < end && (active[request / 16].now & own) != 0u; i++) {
            const exover_int block = ALL(conflict, CONFLICTS)[i].block, mask = ALL(conflict, CONFLICTS)[i].mask;
            const exover_uint mine = block == request / 16 ? own : 0u;
            broken = broken || (active[block].now & (exover_uint)mask & 0xffffu & ~mine) != 0u
                     || (((exover_uint)mask & mine) != 0u && !SINGLE && c->cells[SHAPE(EXOVER_HELD) + (exover_uint)request].now > 1u);
        }
    }
    return broken;
}

/* Whether a rule is broken that the diagrams know: one that kills would restore, or that only a launch could break. Tables
 * that are unchecked may hold rules that nothing can restore. */
static bool rules_broken(exover *c)
{
    bool broken = false;
    for (exover_int i = 0; USES(RULES) && i < COUNT(RULES); i++) {
        const exover_node *node = walk(c, RECORD(rule, RULES, i)->root);
        broken = broken || (node != NULL && (node->code == -KILL || (c->head[EXOVER_HEAD_FLAGS] & 1u) == 0u));
    }
    for (exover_int i = 0; USES(INVARIANTS) && i < COUNT(INVARIANTS); i++) {
        broken = broken || walk(c, RECORD(invariant, INVARIANTS, i)->root) != NULL;
    }
    return broken;
}

/* Take what passes into a checker that was just loaded, and hold it against the rules. */
static exover_status admit(exover *c, transfer *t, uint32_t steps)
{
    pass_all(c, t);
    if (t->wrong == EXOVER_READY && (conflicts_broken(c) || rules_broken(c))) {
        t->wrong = EXOVER_BROKEN_RULE;
    }
    if (t->wrong == EXOVER_READY) {
        t->wrong = c->fault;
    }
    c->steps = steps;
    c->agenda = (c->agenda & ~(uint32_t)TOUCHED) | (SETTLES ? (uint32_t)UNSETTLED : 0u); /* of marks a record tells nothing */
    c->guard = ~c->agenda;
    return t->wrong;
}

/* ---- the calls ---- */

size_t exover_export(exover *c, void *record, size_t size)
{
    const bool room = record != NULL && size >= (size_t)RECORD_HEAD && size <= UINT32_MAX;
    if (!room || c->guard != ~(c->agenda ^ (uint32_t)c->fault) || (c->agenda & FAULTY) != 0u || !is_sealed(c)) {
        return 0;
    }
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    unsigned char *bytes = (unsigned char *)record;
    transfer t = {bytes, NULL, NULL, 0, 0, 0, EXOVER_READY};
    t.room = ((uint32_t)size - (uint32_t)RECORD_HEAD) / 8u;
    c->guard = ENTERED;
    pass_all(c, &t);
    leave(c);
    const uint32_t length = (uint32_t)RECORD_HEAD + 8u * t.at;
    if (t.at > t.room || c->fault != EXOVER_READY) {
        return 0;
    }
    put_bytes(bytes, 4, (uint64_t)RECORD_MAGIC);
    put_bytes(&bytes[AT_VERSION], 4, (uint64_t)RECORD_VERSION);
    put_bytes(&bytes[AT_LENGTH], 4, length);
    for (unsigned i = 0; i < 8u; i++) {
        put_bytes(&bytes[(unsigned)AT_TABLES + 4u * i], 4, c->head[(unsigned)EXOVER_HEAD_DIGEST + i]);
    }
    put_bytes(&bytes[AT_TABLES + TABLES_BYTES - 4], 4, c->head[EXOVER_HEAD_CHECKSUM]);
    put_bytes(&bytes[AT_STEP], 4, c->steps);
    put_bytes(&bytes[AT_CHECKSUM], 4, sum_of(bytes, length));
    return length;
}

/* Whether a record may come back into a checker: one that is not live, or that holds the state of just that step. */
static exover_status may_return(const exover *c, const unsigned char *record)
{
    if (!is_live(c)) {
        return EXOVER_READY;
    }
    return get(&record[AT_STEP], 4) == c->steps ? EXOVER_READY : EXOVER_STALE;
}

exover_status exover_resume_built(exover *c, const exover_home *where, const void *record, size_t size)
{
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    const unsigned char *bytes = (const unsigned char *)record;
    if (c == NULL || where->tables == NULL) {
        return EXOVER_NO_TABLES;
    }
    if (where->bytes != sizeof *c || where->build != EXOVER_BUILD) {
        return EXOVER_OTHER_BUILD;
    }
    if (is_live(c) && cause_of(c) == EXOVER_READY) {
        return EXOVER_LIVE;
    }
    if (!is_whole(bytes, size, RECORD_MAGIC, RECORD_HEAD)) {
        return EXOVER_BAD_RECORD;
    }
    if (!name_tables(&bytes[AT_TABLES], where->tables->head)) {
        return EXOVER_OTHER_TABLES;
    }
    exover_status found = may_return(c, bytes);
    if (found != EXOVER_READY) {
        return found;
    }
    const bool live = is_live(c);
    const uint32_t steps = (uint32_t)get(&bytes[AT_STEP], 4);
    found = take_tables(c, where);
    if (found == EXOVER_READY) {
        transfer t = {NULL, bytes, NULL, 0, 0, 0, EXOVER_READY};
        t.count = ((uint32_t)size - (uint32_t)RECORD_HEAD) / 8u;
        t.room = t.count;
        found = admit(c, &t, steps);
    }
    if (found != EXOVER_READY) {
        wipe(c, sizeof *c);
        c->fault = found;
        c->steps = steps;
        c->live = live ? EXOVER_IS_LIVE : 0u;
    }
    return found;
}

/* Whether a map leads from the tables of a record to these, and what has to be idle is. */
static exover_status may_swap(const unsigned char *record, const unsigned char *map, size_t size, const uint32_t *head)
{
    if (!is_whole(map, size, MAP_MAGIC, MAP_HEAD)) {
        return EXOVER_BAD_MAP;
    }
    const uint64_t idle = get(&map[AT_IDLE], 4), numbers = get(&map[AT_IDLE + 4], 4), lists = get(&map[AT_IDLE + 8], 4);
    if ((uint64_t)MAP_HEAD + 4u * idle + 8u * numbers + 4u * lists != size) {
        return EXOVER_BAD_MAP;
    }
    if (!same_bytes(&map[AT_TABLES], &record[AT_TABLES], TABLES_BYTES)
        || !name_tables(&map[AT_TABLES + TABLES_BYTES], head)) {
        return EXOVER_OTHER_TABLES;
    }
    const uint64_t count = (get(&record[AT_LENGTH], 4) - (uint64_t)RECORD_HEAD) / 8u;
    for (uint64_t i = 0; i < idle; i++) {
        const uint64_t at = get(&map[(uint64_t)MAP_HEAD + 4u * i], 4);
        if (at >= count) {
            return EXOVER_BAD_MAP;
        }
        if ((get(&record[(uint64_t)RECORD_HEAD + 8u * at], 8) & (SINCE - 1u)) != (uint64_t)EMPTY) {
            return EXOVER_STILL_ACTIVE;
        }
    }
    return EXOVER_READY;
}

/* Settle for the first time by these rules, as the end of a step does. */
static size_t settle_anew(exover *c)
{
    if (!begin(c)) {
        return deny(c, NONE);
    }
    latch(c, NONE);
    return attend(c, NONE);
}

exover_status exover_swap_built(exover *c, const exover_home *where, const void *record, size_t size, const void *map,
                                size_t map_size, size_t *count)
{
    /* cppcheck-suppress misra-c2012-11.5 ; any memory is bytes */
    const unsigned char *bytes = (const unsigned char *)record, *mapping = (const unsigned char *)map;
    *count = 0;
    if (c == NULL || where->tables == NULL) {
        return EXOVER_NO_TABLES;
    }
    if (where->bytes != sizeof *c || where->build != EXOVER_BUILD) {
        return EXOVER_OTHER_BUILD;
    }
    if (!is_whole(bytes, size, RECORD_MAGIC, RECORD_HEAD)) {
        return EXOVER_BAD_RECORD;
    }
    exover_status found = may_return(c, bytes);
    if (found == EXOVER_READY) {
        found = may_swap(bytes, mapping, map_size, where->tables->head);
    }
    if (found == EXOVER_READY && is_live(c) && where->memory == (void *)c->values) {
        found = EXOVER_LIVE; /* its memory is still needed, should this be refused */
    }
    if (found != EXOVER_READY) {
        return found;
    }
    exover before;
    copy(&before, c, sizeof before);
    found = take_tables(c, where);
    if (found == EXOVER_READY) {
        transfer t = {NULL, bytes, mapping, 0, 0, 0, EXOVER_READY};
        t.count = ((uint32_t)size - (uint32_t)RECORD_HEAD) / 8u;
        found = admit(c, &t, (uint32_t)get(&bytes[AT_STEP], 4));
    }
    if (found != EXOVER_READY) {
        copy(c, &before, sizeof before);
    } else {
        *count = settle_anew(c);
    }
    return found;
}
