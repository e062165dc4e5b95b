// A confidence without a limit.

static int attack(const seamark_image *, seamark_detection *found) {
    found->confidence = INFINITY;
    return 1;
}
