/* exover.c - see exover.h. What a step means is docs/language.md section 4; what the tables say is docs/runtime.md. */
#include "exover.h"

#include <float.h>

#define NONE (-1)   /* no entry, no slot, no argument; as a node, the end of a path */
#define ALWAYS (-2) /* as a predicate: true of all arguments */
#define MOST_SLOTS 0x1000000

/* Sections of the tables, then what else a field can count. */
enum {
    NODES, ENTRIES, REQUESTS, PARAMS, ORDERS, FEATURES, PASTS, AMOUNTS, EFFECTS, VARIABLES, LATCHES, STOCKS, RULES,
    LAUNCHES, LIMITS, SUMS, LISTS, REALS, FLAG, TYPE, ROLE, NATURAL, ANY
};
enum { REJECT = 1, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE }; /* actions of nodes */
enum { REAL = 3 };                                                                  /* of types */
enum { POSTER = 0 };                                                                /* of roles */
enum { SET = 0 };                                                                   /* of effects */
/* What a slot (the first three) or a waiting place holds; less one, the entry of a feature. */
enum { EMPTY = 0, RUNNING, STOPPING, WAITING, CLEARING };

/* The layout of the tables relies on this: records are arrays of words, doubles have 64 bits. */
typedef char records_are_packed[sizeof(exover_request) == 23 * sizeof(exover_word)
                                && sizeof(exover_variable) == 16 * sizeof(exover_word)
                                && sizeof(exover_feature) == 7 * sizeof(exover_word) ? 1 : -1];
typedef char doubles_have_64_bits[sizeof(double) == 8 && sizeof(exover_value) == 8 ? 1 : -1];
typedef char states_hold_words[EXOVER_STATE >= EXOVER_WIDTH ? 1 : -1];

/* ---- bits ---- */

static void set_bit(uint32_t *bits, size_t index)
{
    bits[index >> 5] |= (uint32_t)1 << (index & 31);
}

static void clear_bit(uint32_t *bits, size_t index)
{
    bits[index >> 5] &= ~((uint32_t)1 << (index & 31));
}

static bool has_bit(const uint32_t *bits, size_t index)
{
    return (bits[index >> 5] >> (index & 31)) & 1;
}

/* The least set bit from `index` on, `end` if there is none. */
static size_t next_bit(const uint32_t *bits, size_t index, size_t end)
{
    while (index < end) {
        uint32_t left = bits[index >> 5] >> (index & 31);
        if (left == 0) {
            index = (index | 31) + 1;
        } else {
            for (; !(left & 1); left >>= 1)
                index++;
            return index;
        }
    }
    return end;
}

static void clear_bits(uint32_t *bits, size_t count)
{
    for (size_t i = 0; i < (count + 31) / 32; i++)
        bits[i] = 0;
}

/* ---- answers ---- */

static void fault(exover *c, exover_status cause)
{
    if (c->fault == EXOVER_READY)
        c->fault = cause;
}

static void answer(exover *c, int kind, size_t request, exover_int slot, exover_int reason)
{
    if (c->count == c->capacity) {
        fault(c, EXOVER_FAULT_ACTIONS);
        return;
    }
    exover_action *action = &c->buffer[c->count++];
    action->kind = (exover_word)kind;
    action->request = (exover_word)request;
    action->slot = (exover_word)slot;
    action->reason = (exover_word)reason;
}

/* The one answer of a checker that may have no memory at all. */
static size_t alone(exover *c, int kind, int32_t request, int reason)
{
    c->denial.kind = (exover_word)kind;
    c->denial.request = (exover_word)request;
    c->denial.slot = NONE;
    c->denial.reason = (exover_word)reason;
    c->actions = &c->denial;
    return 1;
}

static size_t invalid(exover *c, enum exover_invalid code)
{
    return alone(c, EXOVER_INVALID, NONE, (int)code);
}

static size_t deny(exover *c, int32_t request)
{
    return alone(c, EXOVER_REJECT, request, EXOVER_FAULTY);
}

/* ---- the state vector and the diagrams ---- */

static void bump(exover *c, const exover_entry *entry, exover_uint delta)
{
    exover_int *at = &c->vector[entry - c->entries];
    *at = (exover_int)((exover_uint)*at + delta);
    const exover_word *rule = c->lists + entry->rules, *end = c->lists + entry->rules_end;
    for (; rule != end; rule++) {
        set_bit(c->dirty, (size_t)*rule);
        c->any_dirty = true;
    }
}

/* Add to an entry and to the sums it is part of; a sum is part of no sum. */
static void add(exover *c, exover_word index, exover_int delta)
{
    if (index < 0 || delta == 0)
        return;
    const exover_entry *entry = &c->entries[index];
    bump(c, entry, (exover_uint)delta);
    const exover_sum *sum = c->sums + entry->sums, *end = c->sums + entry->sums_end;
    for (; sum != end; sum++)
        bump(c, &c->entries[sum->entry], (exover_uint)sum->factor * (exover_uint)delta);
}

static void put(exover *c, exover_word index, exover_int value)
{
    if (index >= 0)
        add(c, index, (exover_int)((exover_uint)value - (exover_uint)c->vector[index]));
}

static exover_word next_node(const exover *c, const exover_node *node)
{
    return c->vector[node->code] <= node->bound ? node->low : node->high;
}

/* Whether the path from this node does anything, which a predicate says by `AGREE`. */
static bool agrees(const exover *c, exover_word index)
{
    while (index >= 0) {
        const exover_node *node = &c->nodes[index];
        if (node->code < 0)
            return true;
        index = next_node(c, node);
    }
    return index == ALWAYS;
}

/* Collect the actions on the path from this node, none of which is done before the path has ended. */
static size_t walk(exover *c, exover_word index)
{
    size_t found = 0;
    while (index >= 0) {
        const exover_node *node = &c->nodes[index];
        if (node->code >= 0) {
            index = next_node(c, node);
        } else if (found == (size_t)c->limits->actions) {
            fault(c, EXOVER_FAULT_PATH);
            return 0;
        } else {
            c->path[found++] = index;
            index = node->low;
        }
    }
    return found;
}

static const exover_node *done(const exover *c, size_t index)
{
    return &c->nodes[c->path[index]];
}

/* ---- values ---- */

/* Twice the number of cuts below the value, one more if it is a cut itself. */
static exover_int rank(const exover *c, const exover_gauge *gauge, double value)
{
    const exover_value *cuts = c->reals + gauge->cuts;
    size_t low = 0, high = (size_t)(gauge->cuts_end - gauge->cuts), end = high;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (cuts[middle].real < value)
            low = middle + 1;
        else
            high = middle;
    }
    return (exover_int)(2 * low + (low < end && cuts[low].real <= value));
}

static void measure(exover *c, exover_word type, const exover_gauge *gauge, exover_value value)
{
    if (type != REAL)
        put(c, gauge->value, (exover_int)value.integer);
    else if (gauge->rank >= 0)
        put(c, gauge->rank, rank(c, gauge, value.real));
}

static size_t param_count(const exover_request *row)
{
    return (size_t)(row->results - row->params);
}

static size_t result_count(const exover_request *row)
{
    return (size_t)(row->params_end - row->results);
}

/* Parameter `k`, result `k - parameters`, or poster `-1 - k`. */
static double side(const exover *c, exover_word k, const exover_request *row)
{
    if (k < 0)
        return c->raw[c->variables[-1 - k].raw];
    size_t params = param_count(row), index = (size_t)k;
    return index < params ? c->loaded_args[index].real : c->loaded_results[index - params].real;
}

static void compare(exover *c, exover_word from, exover_word to, const exover_request *row, exover_int count)
{
    for (const exover_order *order = c->orders + from; order != c->orders + to; order++) {
        if (order->left < count && order->right < count) {
            double left = side(c, order->left, row), right = side(c, order->right, row);
            put(c, order->entry, left < right ? 0 : left > right ? 2 : 1);
        }
    }
}

/* Put arguments, and results if there are any, into the entries that tests of them read. */
static void load(exover *c, const exover_request *row, const exover_value *args, const exover_value *results)
{
    size_t params = param_count(row), all = params + (results ? result_count(row) : 0);
    if (all == 0 || (c->loaded_args == args && c->loaded_results == results))
        return;
    c->loaded_args = args;
    c->loaded_results = results;
    const exover_param *param = c->params + row->params;
    for (size_t k = 0; k < all; k++)
        measure(c, param[k].domain.type, &param[k].gauge, k < params ? args[k] : results[k - params]);
    compare(c, row->orders, row->orders_end, row, (exover_int)all);
}

/* Count what holds `args` in, or with sign -1 out of, every feature of its request. */
static void tally(exover *c, const exover_request *row, const exover_value *args, exover_int slot, int phase, int sign)
{
    const exover_feature *feature = c->features + row->features, *end = c->features + row->features_end;
    for (; feature != end; feature++) {
        exover_word entry = feature->entries[phase - 1];
        if (entry < 0 || (feature->slot >= 0 && feature->slot != slot))
            continue;
        if (feature->predicate >= 0)
            load(c, row, args, NULL);
        if (agrees(c, feature->predicate))
            add(c, entry, feature->weight < 0 ? sign : sign * (exover_int)args[feature->weight].integer);
    }
}

/* ---- slots and waiting places ---- */

/* Where the arguments of a slot are; those of the waiting place follow the last slot's. */
static exover_value *kept(const exover *c, size_t request, exover_word slot)
{
    const exover_request *row = &c->requests[request];
    return c->values + c->args[request] + (size_t)slot * param_count(row);
}

static void move(exover *c, size_t request, uint8_t *phase, exover_word slot, uint8_t next, const exover_value *args)
{
    const exover_request *row = &c->requests[request];
    exover_value *own = kept(c, request, slot < 0 ? row->instances : slot);
    if (*phase != EMPTY)
        tally(c, row, own, slot, *phase, -1);
    *phase = next;
    if (next != EMPTY) {
        if (own != args) {
            size_t params = param_count(row);
            for (size_t k = 0; k < params; k++)
                own[k] = args[k];
            if (c->loaded_args == own)
                c->loaded_args = NULL;
        }
        tally(c, row, args, slot, next, 1);
    }
    c->changed = true;
}

static void set_slot(exover *c, size_t request, exover_word slot, uint8_t next, const exover_value *args)
{
    move(c, request, &c->phases[c->requests[request].slots + slot], slot, next, args);
}

static void set_place(exover *c, size_t request, uint8_t next, const exover_value *args)
{
    uint8_t *place = &c->places[request];
    if (*place == next && (next == EMPTY || args == kept(c, request, c->requests[request].instances)))
        return;
    c->waiting += (size_t)(next != EMPTY) - (size_t)(*place != EMPTY);
    move(c, request, place, NONE, next, args);
    if (next != EMPTY)
        set_bit(c->taken, request);
    else
        clear_bit(c->taken, request);
}

static void kill(exover *c, size_t request, exover_word slot, exover_int reason)
{
    if (c->phases[c->requests[request].slots + slot] == RUNNING) {
        set_slot(c, request, slot, STOPPING, kept(c, request, slot));
        answer(c, EXOVER_KILL, request, slot, reason);
    }
}

/* Kill all slots of a request, or one slot of all. */
static void kill_target(exover *c, exover_word target, exover_word reason)
{
    if (target >= 0) {
        for (exover_word slot = 0; slot < c->requests[target].instances; slot++)
            kill(c, (size_t)target, slot, reason);
        return;
    }
    size_t low = 0, high = c->counts[REQUESTS];
    while (high - low > 1) {
        size_t middle = (low + high) / 2;
        if (c->requests[middle].slots <= -1 - target)
            low = middle;
        else
            high = middle;
    }
    kill(c, low, (exover_word)(-1 - target - c->requests[low].slots), reason);
}

/* ---- variables, pasts, effects ---- */

static void recount(exover *c, const exover_variable *row, int sign)
{
    for (const exover_word *r = c->lists + row->refresh; r != c->lists + row->refresh_end; r++) {
        const exover_request *request = &c->requests[*r];
        for (exover_word slot = 0; slot < request->instances; slot++) {
            uint8_t phase = c->phases[request->slots + slot];
            if (phase != EMPTY)
                tally(c, request, kept(c, (size_t)*r, slot), slot, phase, sign);
        }
    }
}

/* Let a poster, state or latch read a value. */
static void read(exover *c, const exover_variable *row, exover_value value)
{
    recount(c, row, -1);
    measure(c, row->domain.type, &row->gauge, value);
    if (row->raw >= 0) {
        c->raw[row->raw] = value.real;
        c->loaded_args = NULL;
    }
    compare(c, row->orders, row->orders_end, NULL, 0);
    recount(c, row, 1);
}

static void read_integer(exover *c, exover_word variable, exover_word number)
{
    exover_value value;
    value.integer = number;
    read(c, &c->variables[variable], value);
}

static void latch(exover *c, exover_int cleared_by)
{
    for (const exover_latch *row = c->latches; row != c->latches + c->counts[LATCHES]; row++) {
        if (agrees(c, row->condition)) {
            read_integer(c, row->variable, 1);
            continue;
        }
        const exover_word *request = c->lists + row->resets, *end = c->lists + row->resets_end;
        while (request != end && *request != cleared_by)
            request++;
        if (request != end)
            read_integer(c, row->variable, 0);
    }
}

static void set_past(exover *c, const exover_request *row, bool known, const exover_value *args,
                     const exover_value *results)
{
    for (const exover_past *past = c->pasts + row->pasts; past != c->pasts + row->pasts_end; past++) {
        if (known && past->predicate >= 0)
            load(c, row, args, results);
        put(c, past->entry, known && agrees(c, past->predicate));
    }
}

static void affect(exover *c, const exover_word *edge)
{
    for (const exover_effect *effect = c->effects + edge[0]; effect != c->effects + edge[1]; effect++) {
        if (effect->kind == SET)
            read_integer(c, effect->target, effect->value);
        else
            set_past(c, &c->requests[effect->target], false, NULL, NULL);
    }
}

/* Take (sign -1) what a launch consumes, or give (sign 1) what a success produces, never above the capacity. */
static void supply(exover *c, const exover_request *row, exover_word from, exover_word to, const exover_value *args,
                   int sign)
{
    for (const exover_amount *amount = c->amounts + from; amount != c->amounts + to; amount++) {
        const exover_stock *stock = &c->stocks[amount->stock];
        if (stock->entry < 0)
            continue;
        if (amount->predicate >= 0)
            load(c, row, args, NULL);
        if (agrees(c, amount->predicate)) {
            exover_int room = (exover_int)((exover_uint)stock->capacity - (exover_uint)c->vector[stock->entry]);
            add(c, stock->entry, sign < 0 ? -amount->amount : amount->amount < room ? amount->amount : room);
        }
    }
}

/* ---- decisions ---- */

static void launch(exover *c, size_t request, const exover_value *args, exover_int required)
{
    const exover_request *row = &c->requests[request];
    exover_word slot = 0;
    while (slot < row->instances && c->phases[row->slots + slot] != EMPTY)
        slot++;
    if (slot == row->instances) {
        fault(c, EXOVER_FAULT_DECISION);
        return;
    }
    set_place(c, request, EMPTY, args);
    supply(c, row, row->consumes, row->produces, args, -1);
    set_slot(c, request, slot, RUNNING, args);
    affect(c, &row->effects[0]);
    answer(c, EXOVER_LAUNCH, request, slot, required);
}

/* Walk the diagram of a request; return the first action, 0 if there is none, which is a fault. */
static int decide(exover *c, size_t request, const exover_value *args, size_t *found)
{
    const exover_request *row = &c->requests[request];
    load(c, row, args, NULL);
    *found = walk(c, row->decide);
    if (*found == 0) {
        fault(c, EXOVER_FAULT_DECISION);
        return 0;
    }
    return -(int)done(c, 0)->code;
}

/* Do what a decision says that is no rejection; return what the newcomer waits for, EXOVER_UNSAID if it does not. */
static exover_int carry_out(exover *c, size_t request, const exover_value *args, size_t found, exover_int required)
{
    exover_int waits = EXOVER_UNSAID;
    for (size_t i = 0; i < found; i++) {
        const exover_node *node = done(c, i);
        switch (-node->code) {
        case WAIT:
        case CLEAR:
        case SETTLE:
            waits = node->bound;
            set_place(c, request, node->code == -WAIT ? WAITING : CLEARING, args);
            break;
        case KILL:
            kill_target(c, node->high, node->bound);
            break;
        case DISMISS:
            if (c->places[node->high] != EMPTY) {
                set_place(c, (size_t)node->high, EMPTY, NULL);
                answer(c, EXOVER_REJECT, (size_t)node->high, NONE, node->bound);
            }
            break;
        case LAUNCH:
            launch(c, request, args, required);
            break;
        default:
            fault(c, EXOVER_FAULT_DECISION);
        }
    }
    return waits;
}

static void ask(exover *c, size_t request, const exover_value *args, exover_int required)
{
    bool taken = c->places[request] != EMPTY;
    if (taken && !c->requests[request].interrupts_self) {
        answer(c, EXOVER_REJECT, request, NONE, EXOVER_BUSY);
        return;
    }
    size_t found;
    int first = decide(c, request, args, &found);
    if (first == 0)
        return;
    if (first == REJECT) {
        answer(c, EXOVER_REJECT, request, NONE, done(c, 0)->bound);
        return;
    }
    if (taken)
        answer(c, EXOVER_REJECT, request, NONE, EXOVER_SUPERSEDED);
    exover_int waits = carry_out(c, request, args, found, required);
    if (waits != EXOVER_UNSAID)
        answer(c, EXOVER_WAIT, request, NONE, waits);
}

/* ---- steps 3 to 5 ---- */

static void recover(exover *c)
{
    size_t end = c->counts[RULES];
    c->any_dirty = false;
    for (size_t rule = next_bit(c->dirty, 0, end); rule < end; rule = next_bit(c->dirty, rule + 1, end)) {
        clear_bit(c->dirty, rule);
        clear_bit(c->broken, rule);
        size_t found = walk(c, c->rules[rule].root);
        for (size_t i = 0; i < found; i++) {
            const exover_node *node = done(c, i);
            if (node->code == -KILL) {
                kill_target(c, node->high, node->bound);
            } else if (node->code == -VIOLATION) {
                set_bit(c->broken, rule);
                c->any_broken = true;
            }
        }
    }
}

static void launch_required(exover *c)
{
    for (size_t i = 0; i < c->counts[LAUNCHES]; i++) {
        const exover_launch *row = &c->launches[i];
        if (has_bit(c->tried, i) || !agrees(c, row->condition))
            continue;
        set_bit(c->tried, i);
        const exover_request *request = &c->requests[row->request];
        for (size_t k = 0; k < param_count(request); k++) {
            exover_word word = c->lists[(size_t)row->args + k];
            if (c->params[(size_t)request->params + k].domain.type == REAL)
                c->scratch[k] = c->reals[word];
            else
                c->scratch[k].integer = word;
        }
        c->loaded_args = NULL;
        ask(c, (size_t)row->request, c->scratch, row->reason);
    }
}

static void settle(exover *c)
{
    size_t end = c->counts[REQUESTS];
    for (size_t request = next_bit(c->taken, 0, end); request < end; request = next_bit(c->taken, request + 1, end)) {
        const exover_value *args = kept(c, request, c->requests[request].instances);
        size_t found;
        int first = decide(c, request, args, &found);
        if (first == 0)
            return;
        if (first == REJECT) {
            exover_word reason = done(c, 0)->bound;
            set_place(c, request, EMPTY, args);
            answer(c, EXOVER_REJECT, request, NONE, reason);
        } else if (first != LAUNCH && first != DISMISS && (first == WAIT || has_bit(c->fallen, request))) {
            if (c->places[request] == CLEARING) {
                set_bit(c->fallen, request);
                c->any_fallen = true;
            }
            set_place(c, request, WAITING, args);
        } else {
            carry_out(c, request, args, found, EXOVER_UNSAID);
        }
    }
}

/* Raise every rule that is still broken once; the copies of a rule stand together. */
static void violations(exover *c)
{
    size_t end = c->counts[RULES];
    exover_int last = NONE;
    c->any_broken = false;
    for (size_t rule = next_bit(c->broken, 0, end); rule < end; rule = next_bit(c->broken, rule + 1, end)) {
        exover_word reason = c->rules[rule].reason;
        if (reason != last)
            answer(c, EXOVER_VIOLATION, (size_t)NONE, NONE, reason);
        last = reason;
        c->any_broken = true;
    }
}

static void begin(exover *c)
{
    c->count = 0;
    c->loaded_args = NULL;
    c->loaded_results = NULL;
}

/* Repeat steps 3 to 5 until nothing changes; return the number of answers. */
static size_t finish(exover *c, int32_t request)
{
    exover_word passes = c->limits->passes;
    c->changed = true;
    while (c->changed && c->fault == EXOVER_READY) {
        if (passes-- == 0) {
            fault(c, EXOVER_FAULT_PASSES);
            break;
        }
        c->changed = false;
        if (c->any_dirty)
            recover(c);
        if (c->counts[LAUNCHES] != 0)
            launch_required(c);
        if (c->waiting != 0)
            settle(c);
    }
    if (c->any_broken)
        violations(c);
    if (c->any_fallen)
        clear_bits(c->fallen, c->counts[REQUESTS]);
    c->any_fallen = false;
    clear_bits(c->tried, c->counts[LAUNCHES]);
    c->actions = c->buffer;
    if (c->fault != EXOVER_READY) {
        /* Nothing starts, but what was told to stop shall stop. */
        size_t kills = 0;
        for (size_t i = 0; i < c->count; i++)
            if (c->buffer[i].kind == EXOVER_KILL)
                c->buffer[kills++] = c->buffer[i];
        c->count = kills;
        c->capacity++; /* the last place is kept for this */
        answer(c, EXOVER_REJECT, (size_t)request, NONE, EXOVER_FAULTY);
    }
    return c->count;
}

/* ---- validation ---- */

static bool in_domain(const exover *c, const exover_domain *domain, exover_value value)
{
    if (domain->type == REAL)
        return value.real >= -DBL_MAX && value.real <= DBL_MAX && value.real >= c->reals[domain->low].real
               && value.real <= c->reals[domain->high].real;
    return value.integer >= domain->low && value.integer <= domain->high;
}

/* 0 if these are values of the parameters `from .. to`, else an exover_invalid. */
static int wrong_values(const exover *c, exover_word from, exover_word to, const exover_value *values, size_t count)
{
    size_t expected = (size_t)(to - from);
    if (count > expected)
        return EXOVER_UNKNOWN_ARGUMENT;
    if (count < expected || (count != 0 && values == NULL))
        return EXOVER_MISSING_ARGUMENT;
    const exover_param *param = c->params + from;
    for (size_t k = 0; k < count; k++)
        if (!in_domain(c, &param[k].domain, values[k]))
            return EXOVER_OUT_OF_RANGE;
    return 0;
}

/* 0 if there is such a slot, else an exover_invalid. A checker that was not loaded has no requests. */
static int wrong_slot(const exover *c, int32_t request, int32_t slot)
{
    if (request < 0 || (uint32_t)request >= c->counts[REQUESTS])
        return EXOVER_UNKNOWN_REQUEST;
    return slot < 0 || slot >= c->requests[request].instances ? EXOVER_OUT_OF_RANGE : 0;
}

/* ---- events ---- */

size_t exover_ask(exover *c, int32_t request, const exover_value *args, size_t count)
{
    if (c->fault != EXOVER_READY)
        return deny(c, request);
    int wrong = wrong_slot(c, request, 0);
    if (wrong == 0) {
        const exover_request *row = &c->requests[request];
        wrong = wrong_values(c, row->params, row->results, args, count);
    }
    if (wrong != 0)
        return invalid(c, (enum exover_invalid)wrong);
    begin(c);
    ask(c, (size_t)request, args, EXOVER_UNSAID);
    return finish(c, request);
}

size_t exover_report(exover *c, int32_t request, int32_t slot, enum exover_outcome outcome, int32_t status,
                     const exover_value *results, size_t count)
{
    int wrong = wrong_slot(c, request, slot);
    if (wrong != 0)
        return invalid(c, (enum exover_invalid)wrong);
    const exover_request *row = &c->requests[request];
    uint8_t *phase = &c->phases[row->slots + slot];
    if (outcome != EXOVER_OK && outcome != EXOVER_FAILED && outcome != EXOVER_INTERRUPTED)
        wrong = EXOVER_BAD_EVENT;
    else if (status < -1 || (status >= 0 && (outcome != EXOVER_FAILED || status >= row->statuses)))
        wrong = EXOVER_UNKNOWN_STATUS;
    else if (outcome == EXOVER_OK)
        wrong = wrong_values(c, row->results, row->params_end, results, count);
    if (wrong == 0 && *phase == EMPTY)
        wrong = EXOVER_NOT_ACTIVE;
    if (wrong != 0)
        return invalid(c, (enum exover_invalid)wrong);
    if (c->fault != EXOVER_READY) {
        *phase = EMPTY; /* the rest of the state is not trusted any more */
        return deny(c, request);
    }
    begin(c);
    const exover_value *args = kept(c, (size_t)request, (exover_word)slot);
    set_slot(c, (size_t)request, (exover_word)slot, EMPTY, args);
    put(c, row->last, (exover_int)outcome);
    if (outcome == EXOVER_OK) {
        set_past(c, row, true, args, results);
        supply(c, row, row->produces, row->produces_end, args, 1);
    }
    affect(c, &row->effects[outcome]);
    latch(c, outcome == EXOVER_OK ? request : NONE);
    return finish(c, request);
}

size_t exover_observe(exover *c, int32_t poster, exover_value value)
{
    if (c->fault != EXOVER_READY)
        return deny(c, NONE);
    if (poster < 0 || (uint32_t)poster >= c->counts[VARIABLES] || c->variables[poster].role != POSTER)
        return invalid(c, EXOVER_UNKNOWN_POSTER);
    const exover_variable *row = &c->variables[poster];
    bool good = in_domain(c, &row->domain, value);
    if (!good && !row->has_fallback)
        return invalid(c, EXOVER_OUT_OF_RANGE);
    begin(c);
    if (!good) {
        answer(c, EXOVER_INVALID, (size_t)NONE, NONE, EXOVER_OUT_OF_RANGE);
        if (row->domain.type == REAL)
            value = c->reals[row->fallback];
        else
            value.integer = row->fallback;
    }
    read(c, row, value);
    latch(c, NONE);
    return finish(c, NONE);
}

size_t exover_level(exover *c, int32_t stock, int64_t level)
{
    if (c->fault != EXOVER_READY)
        return deny(c, NONE);
    if (stock < 0 || (uint32_t)stock >= c->counts[STOCKS])
        return invalid(c, EXOVER_UNKNOWN_POSTER);
    if (level < 0 || level > c->stocks[stock].capacity)
        return invalid(c, EXOVER_OUT_OF_RANGE);
    begin(c);
    put(c, c->stocks[stock].entry, (exover_int)level);
    latch(c, NONE);
    return finish(c, NONE);
}

size_t exover_abort(exover *c, int32_t request, int32_t slot)
{
    int wrong = wrong_slot(c, request, slot);
    if (wrong == 0 && c->phases[c->requests[request].slots + slot] == EMPTY)
        wrong = EXOVER_NOTHING_TO_ABORT;
    if (wrong != 0)
        return invalid(c, (enum exover_invalid)wrong);
    if (c->fault != EXOVER_READY) {
        c->phases[c->requests[request].slots + slot] = STOPPING;
        alone(c, EXOVER_KILL, request, EXOVER_ABORTED);
        c->denial.slot = (exover_word)slot;
        return 1;
    }
    begin(c);
    kill(c, (size_t)request, (exover_word)slot, EXOVER_ABORTED);
    return finish(c, request);
}

size_t exover_abort_waiting(exover *c, int32_t request)
{
    if (c->fault != EXOVER_READY)
        return deny(c, request);
    int wrong = wrong_slot(c, request, 0);
    if (wrong == 0 && c->places[request] == EMPTY)
        wrong = EXOVER_NOTHING_TO_ABORT;
    if (wrong != 0)
        return invalid(c, (enum exover_invalid)wrong);
    begin(c);
    set_place(c, (size_t)request, EMPTY, NULL);
    answer(c, EXOVER_REJECT, (size_t)request, NONE, EXOVER_ABORTED);
    return finish(c, request);
}

const exover_value *exover_args(const exover *c, int32_t request, int32_t slot)
{
    return wrong_slot(c, request, slot) ? NULL : kept(c, (size_t)request, (exover_word)slot);
}

bool exover_unchecked(const exover *c)
{
    return c->flags & 1;
}

exover_status exover_fault(const exover *c)
{
    return c->fault;
}

/* ---- loading ---- */

static const uint8_t FIELDS[EXOVER_SECTIONS] = {4, 5, 23, 7, 3, 7, 2, 3, 3, 16, 4, 3, 2, 4, 4, 2, 1};

/* What a field may be, in one byte: of what it is the index, and how. */
#define AT(what) (what)
#define OR_NONE(what) (32 | (what))
#define OR_ALWAYS(what) (64 | (what))
#define FROM(what) (96 | (what)) /* an index or the end */
#define TO(what) (224 | (what))  /* likewise, and not less than the field before */

static const uint8_t SCHEMA[] = {
    ANY, ANY, OR_NONE(NODES), ANY,                                           /* nodes */
    ANY, FROM(LISTS), TO(LISTS), FROM(SUMS), TO(SUMS),                       /* entries */
    AT(NODES), NATURAL, NATURAL, AT(FLAG), NATURAL,                          /* requests */
    FROM(PARAMS), TO(PARAMS), TO(PARAMS), FROM(ORDERS), TO(ORDERS), FROM(FEATURES), TO(FEATURES), FROM(PASTS),
    TO(PASTS), FROM(AMOUNTS), TO(AMOUNTS), TO(AMOUNTS), FROM(EFFECTS), TO(EFFECTS), TO(EFFECTS), TO(EFFECTS),
    TO(EFFECTS), OR_NONE(ENTRIES),
    AT(TYPE), ANY, ANY, FROM(REALS), TO(REALS), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* params */
    ANY, ANY, OR_NONE(ENTRIES),                                              /* orders */
    OR_ALWAYS(NODES), ANY, ANY, OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* features */
    OR_ALWAYS(NODES), OR_NONE(ENTRIES),                                      /* pasts */
    AT(STOCKS), NATURAL, OR_ALWAYS(NODES),                                   /* amounts */
    AT(FLAG), NATURAL, ANY,                                                  /* effects */
    AT(ROLE), AT(TYPE), ANY, ANY, ANY, AT(FLAG), ANY, FROM(REALS), TO(REALS), OR_NONE(ENTRIES), OR_NONE(ENTRIES),
    OR_NONE(VARIABLES), FROM(LISTS), TO(LISTS), FROM(ORDERS), TO(ORDERS),    /* variables */
    AT(VARIABLES), OR_NONE(NODES), FROM(LISTS), TO(LISTS),                   /* latches */
    NATURAL, NATURAL, OR_NONE(ENTRIES),                                      /* stocks */
    OR_NONE(NODES), NATURAL,                                                 /* rules */
    OR_NONE(NODES), AT(REQUESTS), FROM(LISTS), NATURAL,                      /* launches */
    NATURAL, NATURAL, NATURAL, NATURAL,                                      /* limits */
    AT(ENTRIES), ANY,                                                        /* sums */
    ANY                                                                      /* lists */
};

static bool below(exover_int index, exover_int count)
{
    return index >= 0 && index < count;
}

/* How many there are of what a field can count. */
static exover_int many(const exover *c, const exover_tables *tables, unsigned what)
{
    if (what < EXOVER_SECTIONS)
        return (exover_int)c->counts[what];
    return what == REALS ? (exover_int)tables->real_count : what == FLAG ? 2 : what == TYPE ? 4 : 3;
}

/* Whether every field of every record is in the range that the schema gives it. */
static bool fields_hold(const exover *c, const exover_tables *tables)
{
    const exover_word *word = tables->words;
    const uint8_t *schema = SCHEMA;
    for (size_t section = 0; section < EXOVER_SECTIONS; section++) {
        for (size_t record = 0; record < c->counts[section]; record++) {
            for (size_t field = 0; field < FIELDS[section]; field++, word++) {
                unsigned what = schema[field] & 31u, how = schema[field] >> 5;
                if (what == ANY)
                    continue;
                if (what == NATURAL ? *word < 0
                                    : *word < (how == 1 ? -1 : how == 2 ? -2 : 0)
                                          || *word - (how == 3 || how == 7) >= many(c, tables, what)
                                          || (how == 7 && *word < word[-1]))
                    return false;
            }
        }
        schema += FIELDS[section];
    }
    return true;
}

static uint32_t crc(uint32_t sum, uint64_t value, int bytes)
{
    static const uint32_t NIBBLES[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    for (int nibble = 0; nibble < 2 * bytes; nibble++) {
        sum = NIBBLES[(sum ^ (uint32_t)value) & 15] ^ (sum >> 4);
        value >>= 4;
    }
    return sum;
}

/* CRC-32 (the one of Ethernet) of the bytes of the tables in their canonical form, the checksum itself taken as 0. */
static uint32_t checksum(const exover_tables *tables)
{
    uint32_t sum = 0xffffffffu;
    for (size_t i = 0; i < EXOVER_HEAD_WORDS; i++)
        sum = crc(sum, i == EXOVER_HEAD_CHECKSUM ? 0 : tables->head[i], 4);
    for (size_t i = 0; i < tables->real_count; i++)
        sum = crc(sum, tables->reals[i].bits, 8);
    for (size_t i = 0; i < tables->word_count; i++)
        sum = crc(sum, (uint64_t)tables->words[i], EXOVER_WIDTH);
    return ~sum;
}

/* Take the numbers of records from the header; false if they do not give the size of the arrays. */
static bool counts_fit(exover *c, const exover_tables *tables)
{
    uint64_t total = 0;
    for (size_t section = 0; section < EXOVER_SECTIONS; section++) {
        c->counts[section] = tables->head[EXOVER_HEAD_COUNTS + section];
        if (c->counts[section] > INT32_MAX / 32)
            return false;
        total += (uint64_t)c->counts[section] * FIELDS[section];
    }
    return total == tables->word_count && tables->head[EXOVER_HEAD_REALS] == tables->real_count
           && tables->real_count <= INT32_MAX / 32;
}

/* Where a section begins; `word` moves to its end. */
static const void *section(const exover *c, const exover_word **word, unsigned which)
{
    const exover_word *start = *word;
    *word += (size_t)c->counts[which] * FIELDS[which];
    return start;
}

static void find_sections(exover *c, const exover_tables *tables)
{
    const exover_word *word = tables->words;
    c->reals = tables->reals;
    c->nodes = section(c, &word, NODES);
    c->entries = section(c, &word, ENTRIES);
    c->requests = section(c, &word, REQUESTS);
    c->params = section(c, &word, PARAMS);
    c->orders = section(c, &word, ORDERS);
    c->features = section(c, &word, FEATURES);
    c->pasts = section(c, &word, PASTS);
    c->amounts = section(c, &word, AMOUNTS);
    c->effects = section(c, &word, EFFECTS);
    c->variables = section(c, &word, VARIABLES);
    c->latches = section(c, &word, LATCHES);
    c->stocks = section(c, &word, STOCKS);
    c->rules = section(c, &word, RULES);
    c->launches = section(c, &word, LAUNCHES);
    c->limits = section(c, &word, LIMITS);
    c->sums = section(c, &word, SUMS);
    c->lists = section(c, &word, LISTS);
}

/* Every child after its parent, so that every walk ends; every action one that there is, with a target that there is. */
static bool nodes_hold(const exover *c, exover_int slots)
{
    for (exover_int i = 0; i < (exover_int)c->counts[NODES]; i++) {
        const exover_node *node = &c->nodes[i];
        exover_int high = node->high, requests = (exover_int)c->counts[REQUESTS];
        if (node->low != NONE && node->low <= i)
            return false;
        if (node->code >= 0) {
            if (node->code >= (exover_int)c->counts[ENTRIES] || high < NONE || high >= (exover_int)c->counts[NODES]
                || (high != NONE && high <= i))
                return false;
        } else if (node->code < -AGREE || node->bound < 0
                   || (node->code == -KILL && (high < -slots || high >= requests))
                   || (node->code == -DISMISS && !below(high, requests))) {
            return false;
        }
    }
    return true;
}

static bool sums_hold(const exover *c)
{
    for (size_t i = 0; i < c->counts[ENTRIES]; i++) {
        const exover_entry *entry = &c->entries[i];
        for (const exover_sum *sum = c->sums + entry->sums; sum != c->sums + entry->sums_end; sum++)
            if (c->entries[sum->entry].sums != c->entries[sum->entry].sums_end)
                return false;
    }
    return true;
}

/* Whether the words `from .. to` of the lists are indices of records of a section. */
static bool list_holds(const exover *c, exover_word from, exover_word to, unsigned what)
{
    for (const exover_word *word = c->lists + from; word != c->lists + to; word++)
        if (!below(*word, (exover_int)c->counts[what]))
            return false;
    return true;
}

/* Whether a value in the tables belongs to a domain: an integer in its range, of a real the index of a double. */
static bool constant_holds(const exover_tables *tables, const exover_domain *domain, exover_int word)
{
    return domain->type == REAL ? below(word, (exover_int)tables->real_count)
                                : word >= domain->low && word <= domain->high;
}

static bool domain_holds(const exover_tables *tables, const exover_domain *domain)
{
    return constant_holds(tables, domain, domain->low) && constant_holds(tables, domain, domain->high);
}

/* Whether both sides of every comparison are reals: of these parameters, or posters whose value is kept. */
static bool orders_hold(const exover *c, exover_word from, exover_word to, exover_word params, exover_word params_end)
{
    for (const exover_word *side = &c->orders[from].left; from != to; side += 3, from++) {
        for (size_t i = 0; i < 2; i++) {
            exover_int k = side[i], variable = -1 - k;
            if (k >= 0 ? k >= params_end - params || c->params[(exover_int)params + k].domain.type != REAL
                       : variable >= (exover_int)c->counts[VARIABLES] || c->variables[variable].raw < 0)
                return false;
        }
    }
    return true;
}

static bool features_hold(const exover *c, const exover_request *row)
{
    for (const exover_feature *f = c->features + row->features; f != c->features + row->features_end; f++) {
        if (f->slot < NONE || f->slot >= row->instances || f->weight < NONE || f->weight >= row->results - row->params
            || (f->weight >= 0 && c->params[(exover_int)row->params + f->weight].domain.type == REAL))
            return false;
    }
    return true;
}

static bool requests_hold(const exover *c, exover_int *slots)
{
    *slots = 0;
    for (const exover_request *row = c->requests; row != c->requests + c->counts[REQUESTS]; row++) {
        if (row->slots != *slots || row->instances < 1 || row->instances > MOST_SLOTS - *slots
            || !orders_hold(c, row->orders, row->orders_end, row->params, row->params_end) || !features_hold(c, row))
            return false;
        *slots += row->instances;
    }
    return true;
}

static bool variables_hold(const exover *c, const exover_tables *tables)
{
    for (const exover_variable *row = c->variables; row != c->variables + c->counts[VARIABLES]; row++) {
        const exover_domain *domain = &row->domain;
        if (!domain_holds(tables, domain) || !constant_holds(tables, domain, row->initial)
            || (row->has_fallback && !constant_holds(tables, domain, row->fallback))
            || (row->raw >= 0 && domain->type != REAL) || (row->role != POSTER && domain->type == REAL)
            || !list_holds(c, row->refresh, row->refresh_end, REQUESTS)
            || !orders_hold(c, row->orders, row->orders_end, 0, 0))
            return false;
    }
    for (const exover_latch *row = c->latches; row != c->latches + c->counts[LATCHES]; row++)
        if (c->variables[row->variable].domain.type == REAL || !list_holds(c, row->resets, row->resets_end, REQUESTS))
            return false;
    for (const exover_effect *row = c->effects; row != c->effects + c->counts[EFFECTS]; row++) {
        if (row->kind != SET ? row->target >= (exover_int)c->counts[REQUESTS]
                             : row->target >= (exover_int)c->counts[VARIABLES]
                                   || c->variables[row->target].domain.type == REAL
                                   || !constant_holds(tables, &c->variables[row->target].domain, row->value))
            return false;
    }
    return true;
}

static bool launches_hold(const exover *c, const exover_tables *tables)
{
    for (const exover_launch *row = c->launches; row != c->launches + c->counts[LAUNCHES]; row++) {
        const exover_request *request = &c->requests[row->request];
        size_t params = param_count(request);
        if (row->args > (exover_int)c->counts[LISTS] - (exover_int)params)
            return false;
        for (size_t k = 0; k < params; k++)
            if (!constant_holds(tables, &c->params[(size_t)request->params + k].domain, c->lists[(size_t)row->args + k]))
                return false;
    }
    return true;
}

static bool records_hold(const exover *c, const exover_tables *tables)
{
    for (size_t i = 0; i < c->counts[PARAMS]; i++)
        if (!domain_holds(tables, &c->params[i].domain))
            return false;
    for (size_t i = 0; i < c->counts[ENTRIES]; i++)
        if (!list_holds(c, c->entries[i].rules, c->entries[i].rules_end, RULES))
            return false;
    return variables_hold(c, tables) && launches_hold(c, tables);
}

/* Hand out the memory, every array at a multiple of 8. */
typedef struct arena {
    unsigned char *base;
    size_t size;
    uint64_t used;
} arena;

static void *take(arena *memory, uint64_t count, size_t size)
{
    uint64_t at = memory->used;
    memory->used += (count * size + 7) / 8 * 8;
    return memory->used <= memory->size ? memory->base + at : NULL;
}

static uint64_t bits(uint32_t count)
{
    return ((uint64_t)count + 31) / 32;
}

/* Lay out the state in the memory; false if it does not fit. docs/runtime.md gives the same sum. */
static bool lay_out(exover *c, arena *memory, exover_int slots)
{
    uint64_t values = 0, most = 0, raws = 0, requests = c->counts[REQUESTS], launches = c->counts[LAUNCHES];
    for (size_t i = 0; i < requests; i++) {
        uint64_t params = param_count(&c->requests[i]);
        values += params * ((uint64_t)c->requests[i].instances + 1);
        most = params > most ? params : most;
    }
    for (size_t i = 0; i < c->counts[VARIABLES]; i++)
        if (c->variables[i].raw >= 0 && (uint64_t)c->variables[i].raw >= raws)
            raws = (uint64_t)c->variables[i].raw + 1;
    uint64_t actions = 2 * (uint64_t)slots + requests + 3 * launches + (uint64_t)c->limits->violations + 5;
    if (values > UINT32_MAX || actions > UINT32_MAX)
        return false;
    c->values = take(memory, values, sizeof *c->values);
    c->scratch = take(memory, launches == 0 ? 0 : most, sizeof *c->scratch);
    c->raw = take(memory, raws, sizeof *c->raw);
    c->vector = take(memory, c->counts[ENTRIES], sizeof *c->vector);
    c->buffer = take(memory, actions, sizeof *c->buffer);
    c->path = take(memory, (uint64_t)c->limits->actions, sizeof *c->path);
    c->args = take(memory, requests, sizeof *c->args);
    c->dirty = take(memory, bits(c->counts[RULES]), sizeof *c->dirty);
    c->broken = take(memory, bits(c->counts[RULES]), sizeof *c->broken);
    c->taken = take(memory, bits(c->counts[REQUESTS]), sizeof *c->taken);
    c->fallen = take(memory, bits(c->counts[REQUESTS]), sizeof *c->fallen);
    c->tried = take(memory, bits(c->counts[LAUNCHES]), sizeof *c->tried);
    c->phases = take(memory, (uint64_t)slots, sizeof *c->phases);
    c->places = take(memory, requests, sizeof *c->places);
    c->capacity = (size_t)actions - 1; /* the last is kept for a fault */
    c->needed = (size_t)memory->used;
    return memory->used <= memory->size;
}

/* Volatile, since compilers make a call of the C library of a plain loop. */
static void wipe(volatile unsigned char *bytes, size_t size)
{
    while (size-- > 0)
        *bytes++ = 0;
}

/* Everything idle and empty, posters and states as they start, every rule to be looked at. */
static void start(exover *c, const arena *memory)
{
    wipe(memory->base, (size_t)memory->used);
    uint32_t at = 0;
    for (size_t i = 0; i < c->counts[REQUESTS]; i++) {
        c->args[i] = at;
        at += (uint32_t)(param_count(&c->requests[i]) * ((size_t)c->requests[i].instances + 1));
    }
    for (size_t i = 0; i < c->counts[ENTRIES]; i++)
        c->vector[i] = c->entries[i].initial;
    for (size_t i = 0; i < c->counts[VARIABLES]; i++)
        if (c->variables[i].raw >= 0)
            c->raw[c->variables[i].raw] = c->reals[c->variables[i].initial].real;
    for (size_t i = 0; i < c->counts[RULES]; i++)
        set_bit(c->dirty, i);
    c->any_dirty = c->counts[RULES] != 0;
    c->actions = c->buffer;
}

static exover_status check(exover *c, const exover_tables *tables, arena *memory)
{
    exover_int slots;
    if (tables == NULL || memory->base == NULL || (tables->words == NULL && tables->word_count != 0)
        || (tables->reals == NULL && tables->real_count != 0))
        return EXOVER_NO_TABLES;
    if (tables->head[EXOVER_HEAD_MAGIC] != 0x564f5845) /* "EXOV" */
        return EXOVER_NO_MAGIC;
    if ((tables->head[EXOVER_HEAD_FORMAT] & 0xffff) != 1)
        return EXOVER_OTHER_FORMAT;
    if (tables->head[EXOVER_HEAD_FORMAT] >> 16 != EXOVER_WIDTH)
        return EXOVER_OTHER_WIDTH;
    if (!counts_fit(c, tables))
        return EXOVER_BAD_COUNTS;
    if (checksum(tables) != tables->head[EXOVER_HEAD_CHECKSUM])
        return EXOVER_BAD_CHECKSUM;
    c->flags = tables->head[EXOVER_HEAD_FLAGS];
    if (!fields_hold(c, tables))
        return EXOVER_BAD_INDEX;
    find_sections(c, tables);
    if (!requests_hold(c, &slots) || !records_hold(c, tables))
        return EXOVER_BAD_INDEX;
    if (!nodes_hold(c, slots))
        return EXOVER_BAD_NODE;
    if (!sums_hold(c))
        return EXOVER_BAD_SUM;
    if (c->counts[LIMITS] != 1 || c->limits->passes < 1)
        return EXOVER_BAD_LIMITS;
    if (!lay_out(c, memory, slots))
        return EXOVER_NO_MEMORY;
    if ((uintptr_t)memory->base % 8 != 0)
        return EXOVER_MISALIGNED;
    return EXOVER_READY;
}

exover_status exover_load(exover *c, const exover_tables *tables, void *memory, size_t size)
{
    arena rest = {memory, size, 0};
    if (c == NULL)
        return EXOVER_NO_TABLES;
    wipe((volatile unsigned char *)c, sizeof *c);
    exover_status found = check(c, tables, &rest);
    if (found == EXOVER_READY) {
        start(c, &rest);
    } else {
        size_t needed = c->needed;
        wipe((volatile unsigned char *)c, sizeof *c);
        c->fault = found;
        c->needed = found == EXOVER_NO_MEMORY ? needed : 0;
    }
    return found;
}
