"""Core of the manager: decides what a manager does, and leaves the doing to its loop.

Theory of operation
-------------------
*Events in, instructions out.* `core.Core.handle` takes one event and the time, changes the state,
and returns instructions. The loop of the manager calls it, one event after the other, and carries
the instructions out; what comes of them returns as further events. The core opens no file and no
socket, starts no thread and reads no clock, so a test drives it without a process.

*Who owns what.* `state.ManagerState` holds all facts, and only the core changes it. `tasks.Tasks`
owns the procedures under way and their deadlines, `batches.Batches` the requests of clients,
`durable_replies.DurableReplies` the rows on their way to the disk, `supervisor.Supervisor` the
restarts, `change_feed.ChangeFeed` what subscribers know. They share one list of instructions, which
`handle` returns.

*Facts and desires.* Facts (``state.processes``, ``components``, ``connectors``, ``modules``) are
reports of processes. Desired state (``state.kept``) is what users asked for and were acknowledged.
A component that died is no living fact and is still desired; one that a user deleted is neither.

*Processes.* A process is ``starting`` when it is asked for and ``up`` when it said hello. It is
``stopped`` while a signal holds it, and goes on as ``up``. It is ``lost`` when the kernel reported
its end, for ever: keys are used once. A slave of an earlier manager that does not report is
``silent`` until it does, or ends. Processes that attached themselves hold components and are never
ended from here.

*Components.* While a component is made its name is reserved in ``claims``; it is in ``components``
when its container reported it. When its process is lost it becomes a zombie, which keeps its place
and loses its connectors until a restart or a user ends that; where the process was to end, or had
attached itself, the component is forgotten. While it is deleted its name is in ``ending``.

*Procedures.* An action of a client is a generator that yields `effects`: call a container, acquire
a slave, wait for an end, sleep, gather other procedures. `Tasks` resumes it with what it waited
for, or raises in it the error that ended the wait. So one action reads from top to bottom, though
any number are under way. A procedure that fails takes back itself what it had changed. Each wait
has a deadline: no answer is waited for without end, and an answer that comes too late is ignored.
A procedure that can go on is queued, so a batch of any length needs no stack. Between two of its
yields nothing else changes the state.

*A request.* `BatchRequested` begins one procedure for each action, in order or at once. When they
are over, the changes of desired state go to the store in one commit. The reply is sent after that
commit, so what was acknowledged survives the manager. A batch that comes twice with one id is done
once. When the disk refuses, what can be undone is, and nothing new begins until a write succeeds;
what ends or rests something is done all the same, for a robot must be stopped whatever its disk is.

*A death.* `SlaveEnded` marks the components of the process as zombies and cuts their connectors at
the ends that live. The policy of each says whether it returns, the law of restarts when (decision
36), and desired state as what (`recovery`).

*A new manager.* `StoreRead` brings desired state, then living slaves report what they hold
(`SlaveFound`, decision 2) and are believed about facts. When all have, or their time is up,
`RecoveryRequested` makes what is missing. Until then ends are only noted.

*Recorded and replayed.* Events are data: an answer is the number of a request. The loop tells an
`event_ring.EventRing` of each before the core; what is left in it begins with a `checkpoint` of the
core at rest, so that `replay` comes to the same state, in another process too (decision 48). So
nothing here may hang on anything but state, events, the time and the capacity of the host, nor on
the order of a set of texts.

*Invariants*, which the laws check after each step: each component has one process; it is a zombie
exactly when that process is lost; a connector joins two components that live and have such ports;
no full name is used twice; a lost process is forgotten with its last component.
"""
