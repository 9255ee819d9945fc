/* Calls that make no sense: each is refused with its status and words, and the world is what it was. */
#include "thenar.h"
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void expect(ThenarStatus got, ThenarStatus wanted, const char *words, const char *call)
{
    const char *told = thenar_last_error();
    if (got != wanted || (wanted != THENAR_STATUS_OK && strstr(told, words) == NULL)) {
        printf("%s: status %d instead of %d, \"%s\"\n", call, (int)got, (int)wanted, told);
        ++failures;
    }
}
#define REFUSED(call, status, words) expect(call, THENAR_STATUS_##status, words, #call)
#define OK(call) expect(call, THENAR_STATUS_OK, "", #call)

static ThenarWorld *world = NULL;

static atomic_int done = 0;

static void *keep_stepping(void *nothing)
{
    /* The other thread may have it for a moment. */
    while (thenar_world_step(world, 400, NULL) == THENAR_STATUS_BUSY) {
    }
    done = 1;
    return nothing;
}

int main(void)
{
    const char *paper[] = {"hand.0.preset=\"paper\""};
    const char *wrong[] = {"solver.con=\"circular\""};
    const char *none[] = {NULL};
    ThenarWorld *no = (ThenarWorld *)&failures;

    /* Scenes. */
    REFUSED(thenar_world_open(NULL, NULL, 0, &no), ARGUMENT, "file is NULL");
    REFUSED(thenar_world_open("absent.toml", NULL, 0, &no), SCENE, "absent.toml");
    if (no != NULL) {
        printf("a handle was left behind\n");
        ++failures;
    }
    REFUSED(thenar_world_open_named("bred-grasp", NULL, 0, &no), SCENE, "bred-grasp");
    REFUSED(thenar_world_open_named("pinch", wrong, 1, &no), SCENE, "con");
    REFUSED(thenar_world_open_named("pinch", none, 1, &no), ARGUMENT, "overrides is NULL");
    REFUSED(thenar_world_open_named("pinch", NULL, 1, &no), ARGUMENT, "overrides is NULL");
    REFUSED(thenar_world_open_named("pinch", paper, SIZE_MAX, &no), ARGUMENT, "more than there is memory");
    REFUSED(thenar_world_open_named("pinch", NULL, 0, NULL), ARGUMENT, "world is NULL");
    REFUSED(thenar_world_open_named("\xff\xfe", NULL, 0, &no), ARGUMENT, "name is not UTF-8");
    REFUSED(thenar_world_open_text("version = 1\ntime_stp = 1\n", "mine.toml", NULL, 0, &no), SCENE, "mine.toml");
    thenar_world_free(NULL);

    OK(thenar_world_open_named("table-press", paper, 1, &world));
    OK(thenar_world_step(world, 3, NULL));
    uint64_t before = 0, after = 0, steps = 0;
    OK(thenar_world_progress(world, NULL, NULL, &steps, &before));

    /* NULL, wrong sizes, places that are not there. */
    double numbers[175] = {0.0};
    char misaligned[64];
    size_t count = 0;
    REFUSED(thenar_world_step(NULL, 1, NULL), ARGUMENT, "world is NULL");
    REFUSED(thenar_hand_wrist(world, 0, NULL, 7), ARGUMENT, "wrist is NULL");
    REFUSED(thenar_hand_wrist(world, 0, numbers, 6), ARGUMENT, "wrist: expected 7 elements, got 6");
    REFUSED(thenar_hand_wrist(world, 1, numbers, 7), ARGUMENT, "there is no hand 1: there are 1");
    REFUSED(thenar_rigid_pose(world, (size_t)-1, numbers, 7), ARGUMENT, "there is no rigid body");
    REFUSED(thenar_hand_wrist(world, 0, (double *)(void *)((size_t)(misaligned + 8) / 8 * 8 + 1), 7), ARGUMENT, "aligned");
    REFUSED(thenar_soft_nodes(world, 0, NULL, 0, NULL), ARGUMENT, "count is NULL");
    OK(thenar_soft_nodes(world, 0, NULL, 0, &count));
    if (count == 0 || count % 3 != 0) {
        printf("%zu numbers are no nodes\n", count);
        ++failures;
    }
    REFUSED(thenar_soft_nodes(world, 0, numbers, 175, &count), ARGUMENT, "and room for 175");
    REFUSED(thenar_soft_nodes(world, 5, numbers, 175, &count), ARGUMENT, "there is no deformable body 5");

    /* Poses and settings. */
    OK(thenar_hand_wrist(world, 0, numbers, 7));
    double angles[20] = {0.0};
    angles[4] = NAN;
    REFUSED(thenar_hand_follow_angles(world, 0, 0.0, numbers, 7, angles, 20), POSE, "a joint angle");
    REFUSED(thenar_hand_follow_angles(world, 0, 0.0, numbers, 7, angles, 19), ARGUMENT, "angles: expected 20");
    angles[4] = 0.0;
    REFUSED(thenar_hand_follow_angles(world, 0, INFINITY, numbers, 7, angles, 20), POSE, "time");
    numbers[0] = 99.0;
    REFUSED(thenar_hand_follow_angles(world, 0, 0.0, numbers, 7, angles, 20), POSE, "99");
    memset(numbers, 0, sizeof numbers);
    REFUSED(thenar_hand_follow_joints(world, 0, 0.0, numbers, 175, NULL, 0), POSE, "quaternion");
    REFUSED(thenar_hand_follow_joints(world, 0, 0.0, numbers, 174, NULL, 0), ARGUMENT, "joints: expected 175");
    REFUSED(thenar_world_set(world, "frction", 1.0), SETTING, "frction");
    REFUSED(thenar_world_set(world, "friction", NAN), SETTING, "friction");
    REFUSED(thenar_world_set_word(world, "solver", "magic"), SETTING, "magic");

    /* States: a byte changed, one missing, another scene's. */
    size_t size = 0;
    OK(thenar_world_state(world, NULL, 0, &size));
    uint8_t *state = malloc(size);
    if (state == NULL)
        return 1;
    REFUSED(thenar_world_state(world, state, size - 1, &size), ARGUMENT, "and room for");
    OK(thenar_world_state(world, state, size, &size));
    state[size / 2] ^= 1;
    REFUSED(thenar_world_set_state(world, state, size), STATE, "damaged");
    state[size / 2] ^= 1;
    REFUSED(thenar_world_set_state(world, state, size - 1), STATE, "damaged");
    REFUSED(thenar_world_set_state(world, NULL, size), ARGUMENT, "state is NULL");
    ThenarWorld *other = NULL;
    OK(thenar_world_open_named("falling-box", NULL, 0, &other));
    REFUSED(thenar_world_set_state(other, state, size), STATE, "another scene");
    thenar_world_free(other);

    OK(thenar_world_progress(world, NULL, NULL, NULL, &after));
    if (before != after || steps != 3) {
        printf("the world has changed\n");
        ++failures;
    }

    /* A state goes on with the same bits. */
    uint64_t first = 0, again = 0;
    OK(thenar_world_step(world, 5, NULL));
    OK(thenar_world_progress(world, NULL, NULL, NULL, &first));
    OK(thenar_world_set_state(world, state, size));
    OK(thenar_world_step(world, 5, NULL));
    OK(thenar_world_progress(world, NULL, NULL, NULL, &again));
    if (first != again) {
        printf("other bits\n");
        ++failures;
    }
    free(state);

    /* Another thread steps it. */
    int busy = 0;
    pthread_t thread;
    if (pthread_create(&thread, NULL, keep_stepping, NULL) != 0)
        return 1;
    while (!done)
        if (thenar_world_step(world, 0, NULL) == THENAR_STATUS_BUSY && strstr(thenar_last_error(), "another thread"))
            ++busy;
    pthread_join(thread, NULL);
    if (busy == 0) {
        printf("two threads had the world at once\n");
        ++failures;
    }
    thenar_world_free(world);
    if (failures == 0)
        printf("all refused\n");
    return failures != 0;
}
