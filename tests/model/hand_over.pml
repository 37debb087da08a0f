/* Who holds the lease: two clients take free control, take over, give back and hand over, by commands that arrive late, again or never, and a
 * core that moves while its holder drives. The rules are those of take_lease and release_lease in control/core/serve/commands.cpp; with one
 * of them taken away by -D the search must find control that nobody gave (tests/model/CMakeLists.txt). What a new lease means for driving is
 * remote_drive.pml's: it grants one at any standstill. */
#define EPOCHS 5

byte epoch = 0, holder = 0; /* 0: nobody; else client 1 or 2 */
bool moving = false;

/* what is on its way: client c says of the lease `said[c]` that it hands it to the other; kept, so that it arrives late and again */
byte said[3]; byte believed[3]; /* the lease that a client was told last that it holds; 0: none */

inline grant(to)
{
  assert(!moving || holder == 0);
  epoch++; holder = to; moving = false;
  if
  :: to != 0 -> believed[to] = epoch
  :: else
  fi
}

#ifdef NO_HANDED_EPOCH
#define of_this_lease(c) true
#else
#define of_this_lease(c) (said[c] == epoch)
#endif
#ifdef NO_STANDSTILL
#define stands true
#else
#define stands (!moving)
#endif

/* What the server asks of its own list before it passes a hand-over on: the holder, as it knew it. It may be late, so it proves nothing. */
#define CLIENT(c) \
  :: atomic { holder == 0 && epoch < EPOCHS -> grant(c) } /* free control */ \
  :: atomic { holder == 3 - c && !moving && epoch < EPOCHS -> grant(c) } /* taken over */ \
  :: atomic { holder == c && epoch < EPOCHS -> moving = false; grant(0) } /* given back, or its connection has ended: the hoist stops */ \
  :: atomic { believed[c] > 0 && said[c] != believed[c] -> said[c] = believed[c] } \
  :: atomic { said[c] > 0 && holder != 0 && of_this_lease(c) && stands && epoch < EPOCHS -> \
       assert(said[c] == epoch); assert(holder == c); grant(3 - c) } \
  :: atomic { said[c] > 0 -> said[c] = 0 } /* lost */

init {
  do
  CLIENT(1)
  CLIENT(2)
  :: atomic { holder != 0 -> moving = !moving }
  :: epoch == EPOCHS -> break
  od
}
