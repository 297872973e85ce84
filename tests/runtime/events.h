/* Random events on any tables. For tests: hosted. Include exover.h, or what includes it, before. */
#ifndef EVENTS_H
#define EVENTS_H

static uint64_t lot;

static uint32_t draw(uint32_t below)
{
    lot = lot * 6364136223846793005u + 1442695040888963407u;
    return below == 0 ? 0 : (uint32_t)(lot >> 33) % below;
}

static exover_value any_value(void)
{
    static const double REALS[] = {0.0, 0.5, 1.0, -1.0, 1e300, 0.2, 40.0};
    exover_value value;
    switch (draw(8)) {
    case 0: value.bits = lot; break;
    case 1: value.bits = UINT64_C(0x7ff8000000000000); break;
    case 2:
    case 3:
    case 4: value.real = REALS[draw(7)]; break;
    default: value.integer = (int64_t)draw(5) - 1;
    }
    return value;
}

static size_t event(exover *c)
{
    exover_value values[64];
    int32_t request = (int32_t)draw(c->shape[EXOVER_COUNTS + 2] + 2) - 1;
    int32_t slot = draw(8) == 0 ? (int32_t)draw(4) - 1 : 0;
    size_t count = draw(16) == 0 ? draw(4) : exover_arity(c, request);
    for (size_t i = 0; i < 64; i++)
        values[i] = any_value();
    count = count < 64 ? count : 64;
    switch (draw(8)) {
    case 0:
    case 1:
    case 2: return exover_ask(c, request, values, count);
    case 3:
    case 4:
        count = draw(4);
        return exover_report(c, request, slot, (enum exover_outcome)(draw(4)), (int32_t)draw(3) - 1, values, count);
    case 5: return exover_observe(c, (int32_t)draw(c->shape[EXOVER_COUNTS + 9] + 2) - 1, values[0]);
    case 6: return exover_level(c, (int32_t)draw(c->shape[EXOVER_COUNTS + 11] + 2) - 1, values[0].integer);
    default: return draw(2) ? exover_abort(c, request, slot) : exover_abort_waiting(c, request);
    }
}

#endif
