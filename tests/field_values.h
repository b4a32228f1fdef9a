/* The functions of shapes_fields.h, in the precision NUMBER; its names end as NAMED says. Included
 * once for each precision, as the maths is the same. */

static NUMBER NAMED(balls_value)(const void *user, NUMBER x, NUMBER y, NUMBER z) {
    (void)user;
    NUMBER sum = (NUMBER)balls.threshold;
    for (int i = 0; i < BALLS; i++) {
        NUMBER a = x - (NUMBER)balls.center[i].x, b = y - (NUMBER)balls.center[i].y,
               c = z - (NUMBER)balls.center[i].z, r = (NUMBER)balls.radius[i];
        NUMBER left = 1 - (a * a + b * b + c * c) / (r * r);
        if (left > 0) sum -= (NUMBER)balls.strength[i] * left * left * left;
    }
    return sum;
}

static NUMBER NAMED(formula_wave)(NUMBER x, NUMBER y, NUMBER z) {
    return sin(8 * x) * cos(8 * y) + sin(8 * y) * cos(8 * z) + sin(8 * z) * cos(8 * x);
}

static NUMBER NAMED(formula_value)(const void *user, NUMBER x, NUMBER y, NUMBER z) {
    (void)user;
    const NUMBER a = (NUMBER)formula.a, b = (NUMBER)formula.b, tenth = (NUMBER)0.1L;
    switch (formula.kind) {
    case 0: return x * x + y * y + z * z - a + (NUMBER)0.02L * sin(9 * x) * sin(9 * y) * cos(9 * z);
    case 1: {
        NUMBER r = sqrt(x * x + z * z) - a;
        return sqrt(r * r + y * y) - b;
    }
    case 2: {
        NUMBER box = fmax(fmax(fabs(x), fabs(y)), fabs(z)) - a, aside = x - (NUMBER)0.2L;
        NUMBER ball = sqrt(aside * aside + y * y + z * z) - b;
        NUMBER h = fmax(1 - fabs(box - ball) / tenth, (NUMBER)0);
        return fmin(box, ball) - h * h * tenth / 4;
    }
    case 3: return fmax(fabs(NAMED(formula_wave)(x, y, z)) - 0.5f, x * x + y * y + z * z - a);
    case 4: return exp(-4 * (x * x + y * y)) * a - 1.5f * z * z - tenth;
    default: return y - a * atan(5 * x) / (1 + z * z) + tenth * sqrt(x * x + (NUMBER)0.01L);
    }
}

/* A quaternion by the product of any two: (r, v) (s, w) = (r s - v w, r w + s v + v x w), where both
 * are the same and v x v = 0. */
static NUMBER NAMED(julia_value)(const void *user, NUMBER r, NUMBER i, NUMBER j) {
    const julia_like *s = user;
    NUMBER k = s->slice, square = r * r + i * i + j * j + k * k;
    for (int n = 0; n < s->iterations && square < 1e40; n++) {
        NUMBER twice = 2 * r;
        r = r * r - (i * i + j * j + k * k) + s->c.x;
        i = twice * i + s->c.y;
        j = twice * j + s->c.z;
        k = twice * k + s->c_k;
        square = r * r + i * i + j * j + k * k;
    }
    return log((square + (NUMBER)1e-30L) / (NUMBER)julia_escape_squared) / (1 << s->iterations);
}

#undef NUMBER
#undef NAMED
