/* A hand presses on a table; then it is led up by poses. Prints what each part presses with.
 *
 * Build, from this folder, after `cargo build --release -p thenar-c`:
 *   cc -I../include press.c ../../../target/release/libthenar_c.a -lpthread -ldl -lm -o press
 */
#include "thenar.h"
#include <stdio.h>
#include <stdlib.h>

static const char *const PARTS[6] = {"palm", "thumb", "index", "middle", "ring", "little"};

/* Ends the program, in the library's words, where a call was refused. */
static void check(ThenarStatus status)
{
    if (status != THENAR_STATUS_OK) {
        fprintf(stderr, "error: %s\n", thenar_last_error());
        exit(1);
    }
}

int main(void)
{
    if (thenar_abi_version() != THENAR_ABI_VERSION) {
        fprintf(stderr, "error: the header is of another version than the library\n");
        return 1;
    }

    /* The scene comes along; the paper's hand and longer steps are quick. */
    const char *set[] = {"hand.0.preset=\"paper\"", "time_step=0.01"};
    ThenarWorld *world = NULL;
    check(thenar_world_open_named("table-press", set, 2, &world));

    /* Its script lays the hand down and presses. */
    ThenarReport report;
    check(thenar_world_step(world, 150, &report));
    ThenarLoad loads[6];
    check(thenar_hand_loads(world, 0, loads, 6));
    double total = 0.0;
    for (int part = 0; part < 6; ++part) {
        printf("%-8s %7.3f N on %6.1f mm2\n", PARTS[part], loads[part].normal, 1e6 * loads[part].area);
        total += loads[part].normal;
    }
    printf("pressed with %.4f N\n", total);

    /* First how many contacts there are, then the contacts. */
    size_t count = 0;
    check(thenar_world_contacts(world, NULL, 0, &count));
    ThenarContact *contacts = calloc(count, sizeof *contacts);
    if (contacts == NULL)
        return 1;
    check(thenar_world_contacts(world, contacts, count, &count));
    size_t deepest = 0;
    for (size_t k = 1; k < count; ++k)
        if (contacts[k].gap < contacts[deepest].gap)
            deepest = k;
    printf("contacts %zu, the deepest %.3f mm inside\n", count, -1e3 * contacts[deepest].gap);
    free(contacts);

    /* From here on poses move it: the wrist goes up by 40 mm in 0.2 s and stays there, the fingers as they are. */
    double wrist[7], angles[20], time = 0.0, step = 0.0;
    check(thenar_hand_wrist(world, 0, wrist, 7));
    check(thenar_hand_angles(world, 0, angles, 20));
    check(thenar_world_progress(world, NULL, &step, NULL, NULL));
    const double begin = wrist[1];
    for (; time < 0.7; time += step) {
        wrist[1] = begin + 0.04 * (time < 0.2 ? time / 0.2 : 1.0);
        check(thenar_hand_follow_angles(world, 0, time, wrist, 7, angles, 20));
        check(thenar_world_step(world, 1, NULL));
    }
    check(thenar_hand_wrist(world, 0, wrist, 7));
    printf("wrist rose by %.2f mm\n", 1e3 * (wrist[1] - begin));

    /* What makes no sense is refused, with words. */
    if (thenar_hand_loads(world, 7, loads, 6) != THENAR_STATUS_OK)
        printf("refused: %s\n", thenar_last_error());
    thenar_world_free(world);
    return 0;
}
