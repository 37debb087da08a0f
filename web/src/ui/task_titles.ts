// Titles of the clinical tasks, which only their files have.
import { useQuery } from '../link/query';
import { rest } from '../link/rest';
import { words } from '../text/text';

/** The title of a task by its name; the name itself until the list is here, and for a task that this hoist no longer has. */
export function useTaskTitles(): (task: string) => string {
  const asked = useQuery(() => rest('GET /api/v1/tasks'), []);
  return (task) => {
    const row = asked.value?.items.find(({ name }) => name === task);
    return row === undefined ? task : words(row.title);
  };
}
