/* Leading by hand over a channel that loses, delays, reorders and doubles: a client with a stick and hold-to-run, a rival that takes the lease
 * and gives it back, and the core that judges by its own clock. In GUIDED the button is the same hold-to-run (modes/hold_to_run.hpp): what is
 * "pushed" here is "held" there. The rules are those of control/core/command/{lease,remote_drive}.hpp; with one of them taken away by -D
 * the search must find a way to hurt somebody (tests/model/CMakeLists.txt does that for each).
 *
 * Time is counted in units of 250 ms, the one limit of the design: a command's age counts from the telemetry that it echoes, and it acts while
 * that is at most AGE units old. So a hand that is off the stick (let go, tab closed, link cut, tablet on the floor) has stopped the hoist
 * after AGE units, whatever the channel does. */
#define AGE 1
#define END 5
#define SLOTS 2

typedef Message { bool used; byte epoch; byte number; byte echo; bit stick; }
#define OFF 0    /* hold-to-run not held, or the stick in the middle: the core takes them for the same */
#define PUSHED 1 /* held and pushed */

Message air[SLOTS];
byte now = 0;

/* the client: where the hand is, the newest telemetry seen, the lease believed in (0: none yet), the number of the next command */
bit hand = OFF; byte seen = 0; byte believed = 0; byte number = 1;
byte since_push = END + 1; /* true value for the assertions: units since the hand pushed; END + 1: never */

/* the core */
bool ours = false; /* the client holds the lease; else the rival or nobody */
byte epoch = 0; byte taken_number = 0; byte hand_at = 0; bit stick = OFF; bool awaits_neutral = false;

/* true values for the assertions */
bool gap = false;         /* commands stopped coming while pushed, and no middle position has been taken since */
byte let_go_number = 0;   /* number of the newest accepted let-go of this lease */

#define moving (stick == PUSHED && !awaits_neutral)

inline judge()
{
  if
  :: moving ->
     assert(since_push <= AGE);
     assert(!gap)
  :: else
  fi
}

inline take(m)
{
  if
  :: (ours
#ifndef NO_EPOCH
      && m.epoch == epoch
#endif
#ifndef NO_SEQUENCE
      && m.number > taken_number
#endif
      && (m.stick == OFF
#ifdef NO_ECHO
      || true
#endif
      || now - m.echo <= AGE)) ->
     if
     :: m.stick == PUSHED -> assert(m.epoch == epoch); assert(m.number > let_go_number)
     :: else
     fi;
     taken_number = m.number; stick = m.stick;
#ifdef NO_DELAY
     hand_at = now; /* counted from acceptance: the delay of the channel is left out */
#else
     hand_at = (m.echo > hand_at -> m.echo : hand_at);
#endif
     if
     :: m.stick != PUSHED && now - m.echo <= AGE -> awaits_neutral = false; gap = false
     :: else
     fi;
     if
     :: m.stick == OFF && m.number > let_go_number -> let_go_number = m.number
     :: else
     fi;
     judge()
  :: else
  fi
}

/* A new holder, only while nothing moves: everything of the former one is void. */
inline grant(to_us)
{
  epoch++; ours = to_us; taken_number = 0; hand_at = now; stick = OFF; awaits_neutral = true; gap = false; let_go_number = 0;
  if
  :: to_us -> believed = epoch; number = 1
  :: else
  fi
}

#define SEND(i) atomic { believed > 0 && number < 4 && !air[i].used -> air[i].used = true; air[i].epoch = believed; air[i].number = number; \
  air[i].echo = seen; air[i].stick = hand; number++ }
#define DROP(i) air[i].used = false; air[i].epoch = 0; air[i].number = 0; air[i].echo = 0; air[i].stick = 0

init {
  do
  :: atomic { now < END ->   /* time passes; the core's step */
       now++;
       if
       :: hand == PUSHED -> since_push = 0
       :: hand != PUSHED && since_push <= END -> since_push++
       :: else
       fi;
#ifndef NO_SILENCE
       if
       :: stick != OFF && now - hand_at > AGE ->
          if
          :: stick == PUSHED -> gap = true
          :: else
          fi;
          stick = OFF;
#ifndef NO_NEUTRAL
          awaits_neutral = true
#endif
       :: else
       fi;
#endif
       judge()
     }
  /* the hand moves, telemetry is seen, a command is sent, the lease is given to us or to the rival */
  :: atomic { hand == OFF -> hand = PUSHED; since_push = 0 } :: atomic { hand == PUSHED -> hand = OFF }
  :: atomic { seen != now -> seen = now }
  :: SEND(0) :: SEND(1)
  :: atomic { epoch < 3 && !moving && !ours -> grant(true) } :: atomic { epoch < 3 && !moving && ours -> grant(false) }
  /* the channel: a command arrives, arrives and stays on its way to arrive again, or is lost */
  :: atomic { air[0].used -> take(air[0]); DROP(0) } :: atomic { air[0].used -> take(air[0]) } :: atomic { air[0].used -> DROP(0) }
  :: atomic { air[1].used -> take(air[1]); DROP(1) } :: atomic { air[1].used -> take(air[1]) } :: atomic { air[1].used -> DROP(1) }
  :: now == END -> break
  od
}
